#include "daemon/cli/client.h"
#include "daemon/cli/offline_commands.h"
#include "daemon/version.h"

#include <csignal>
#include <cstdio>
#include <string>
#include <vector>

namespace {

constexpr const char* kHelp = R"(usage: voidpath COMMAND ...

Without daemon or printer:
  orient MODEL               choose the orientation        slice MODEL -o OUT.gcode   make G-code
  estimate FILE.gcode        time G-code                   check MODEL                can it be printed
  evaluate DIR --out DIR     compare methods               weights DIR --out FILE     find the weights
  profile list|show|import   profiles; import reads PrusaSlicer's

With the daemon (--config FILE or --host HOST:PORT say where it is; --printer NAME where there are several):
  status [--json]            what goes on                  queue                      what is to be printed
  add FILE... [--as-delivered] [--method M] [--copies N] [--scale F] [--slicer NAME]
  remove JOB                 take out of the queue         move JOB POS               1 is next
  pause, resume              the running print             cancel [JOB]               end it, heaters off
  stop                       emergency stop                bed-clear                  the bed is empty: go on
  power on|off               the printer's relay           light on|off
  retry JOB                  the same again
  resume-interrupted JOB     print an interrupted one again from its beginning
  discard JOB                give an interrupted one up
  history [--json|--csv]     measured prints               calibration [--json]       what they taught
  watch [-f]                 follow what goes on           logs [-f]                  events
  terminal                   talk to the printer

voidpath COMMAND --help tells more of the first group. Exit codes: 0 done; 1 it failed; 2 wrong usage or
configuration; 3 input refused; 4 daemon or printer not reachable.
)";

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGPIPE, SIG_IGN);
  const std::vector<std::string> args(argv + 1, argv + argc);
  if (args.empty()) {
    std::fputs(kHelp, stderr);
    return voidpath::cli::kUsage;
  }
  const std::string& command = args.front();
  if (command == "--help" || command == "-h" || command == "help") {
    std::fputs(kHelp, stdout);
    return 0;
  }
  if (command == "--version") {
    std::printf("voidpath %s\n", voidpath::daemon::version());
    return 0;
  }
  const std::vector<std::string> rest(args.begin() + 1, args.end());
  if (voidpath::cli::is_client(command)) {
    for (const auto& arg : rest) {
      if (arg == "--help" || arg == "-h") {
        std::fputs(kHelp, stdout);
        return 0;
      }
    }
    return voidpath::cli::run_client(command, rest);
  }
  if (voidpath::cli::is_offline(command)) return voidpath::cli::run_offline(command, rest);
  std::fprintf(stderr, "voidpath: there is no command %s; voidpath --help lists them\n", command.c_str());
  return voidpath::cli::kUsage;
}

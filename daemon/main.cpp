#include "config/config.h"
#include "daemon/app.h"
#include "daemon/event_loop.h"
#include "daemon/pins/printer_pins.h"
#include "daemon/version.h"

#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>

namespace {

constexpr const char* kHelp =
    "usage: voidpathd [--config FILE] [--state-dir DIR] [--check | --pins-off]\n"
    "Watches folders, prepares what is dropped there and prints it. Runs in the foreground until SIGTERM.\n"
    "  --config FILE    default: $VOIDPATH_CONFIG, ~/.config/voidpath/voidpath.yaml, "
    "/etc/voidpath/voidpath.yaml\n"
    "  --state-dir DIR  instead of the configuration's state_dir\n"
    "  --check          checks the configuration and ends\n"
    "  --pins-off       switches relays and lamps off and ends; for when the daemon has died\n"
    "exit codes: 0 done; 1 it failed; 2 wrong usage or configuration\n";

struct Flags {
  std::string config;
  std::string state_dir;
  bool check = false;
  bool pins_off = false;
};

int usage(const std::string& what) {
  std::fprintf(stderr, "voidpathd: %s\n%s", what.c_str(), kHelp);
  return 2;
}

int run(const Flags& flags) {
  using namespace voidpath;
  const std::filesystem::path file =
      flags.config.empty() ? config::default_config_file() : std::filesystem::path(flags.config);
  if (file.empty()) {
    std::fprintf(stderr,
                 "voidpathd: there is no configuration; write /etc/voidpath/voidpath.yaml or use --config\n");
    return 2;
  }
  auto settings = config::load_daemon(file);
  if (flags.pins_off) {
    daemon::switch_pins_off(settings, *fw::kernel_pins());
    return 0;
  }
  if (!flags.state_dir.empty()) settings.state_dir = flags.state_dir;
  settings = daemon::with_plain_paths(std::move(settings));
  daemon::check_config(settings);
  if (flags.check) {
    std::printf("%s: %zu printer(s), all profiles found\n", file.c_str(), settings.printers.size());
    return 0;
  }
  daemon::block_signals();
  std::signal(SIGPIPE, SIG_IGN);
  daemon::App app(std::move(settings));
  app.run();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Flags flags;
  for (int i = 1; i < argc; ++i) {
    const std::string arg = argv[i];
    if (arg == "--help" || arg == "-h") {
      std::fputs(kHelp, stdout);
      return 0;
    }
    if (arg == "--version") {
      std::printf("voidpathd %s\n", voidpath::daemon::version());
      return 0;
    }
    if (arg == "--check") {
      flags.check = true;
    } else if (arg == "--pins-off") {
      flags.pins_off = true;
    } else if ((arg == "--config" || arg == "--state-dir") && i + 1 < argc) {
      (arg == "--config" ? flags.config : flags.state_dir) = argv[++i];
    } else {
      return usage("do not know \"" + arg + "\"");
    }
  }
  try {
    return run(flags);
  } catch (const voidpath::config::ConfigError& error) {
    std::fprintf(stderr, "voidpathd: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "voidpathd: %s\n", error.what());
    return 1;
  }
}

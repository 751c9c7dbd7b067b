#include "daemon/cli/offline_commands.h"

#include <array>
#include <cstdio>
#include <utility>

#include "daemon/cli/offline.h"

namespace voidpath::cli {

namespace {

using Command = int (*)(const std::vector<std::string>&);

constexpr std::array<std::pair<const char*, Command>, 7> kCommands = {{{"orient", orient_command},
                                                                       {"slice", slice_command},
                                                                       {"estimate", estimate_command},
                                                                       {"check", check_command},
                                                                       {"weights", weights_command},
{"evaluate", evaluate_command},
                                                                       {"profile", profile_command}}};

// Exit codes of the command line's contract.
constexpr int kFailed = 1;
constexpr int kUsage = 2;
constexpr int kRefused = 3;

int complain(int code, const std::string& what) {
  end_progress();
  std::fprintf(stderr, "voidpath: %s\n", what.c_str());
  return code;
}

}  // namespace

bool is_offline(const std::string& command) {
  for (const auto& [name, run] : kCommands)
    if (command == name) return true;
  return false;
}

int run_offline(const std::string& command, const std::vector<std::string>& args) {
  try {
    for (const auto& [name, run] : kCommands)
      if (command == name) return run(args);
    return complain(kUsage, "unknown command '" + command + "'");
  } catch (const UsageError& e) {
    return complain(kUsage, e.what());
  } catch (const config::ConfigError& e) {
    return complain(kUsage, e.what());
  } catch (const mesh::ImportError& e) {
    return complain(kRefused, e.what());
  } catch (const orient::NothingFits& e) {
    return complain(kRefused, e.what());
  } catch (const pipeline::Refused& e) {
    return complain(kRefused, e.what());
  } catch (const std::exception& e) {
    return complain(kFailed, e.what());
  }
}

}  // namespace voidpath::cli

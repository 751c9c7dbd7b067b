#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace voidpath::bench {

/// What a program took, by the kernel's account.
struct Usage {
  bool ok = false;  ///< ended by itself with code 0
  bool timed_out = false;
  double wall_s = 0;
  double cpu_s = 0;  ///< user and system, all threads
  double peak_mb = 0;
};

/// Runs a program to its end with standard output and error in `log`; killed after `limit_s`.
/// Throws std::system_error when it cannot be started.
Usage run_child(const std::vector<std::string>& command, const std::filesystem::path& log, double limit_s);

}  // namespace voidpath::bench

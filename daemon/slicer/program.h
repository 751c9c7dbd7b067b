#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

/// Running another program on a short leash.
namespace voidpath::daemon {

struct ProgramCall {
  std::vector<std::string> args;  ///< args[0] is the program's file; no shell sees them
  std::vector<std::pair<std::string, std::string>> environment;  ///< laid over our own
  std::filesystem::path folder;                                  ///< it starts there
  std::filesystem::path log;                                     ///< takes its standard output and error
  double time_limit_s = 0;
  std::uint64_t memory_limit_bytes = 0;  ///< 0: none
};

struct ProgramEnd {
  enum class Kind { exited, killed, timed_out, stopped } kind = Kind::exited;
  int code = 0;  ///< exit code, or the signal that killed it
};

/// The program's file, looked up in PATH unless it has a slash; empty if there is none that may be run.
std::filesystem::path find_program(const std::string& name);

/// Runs the program to its end, in a process group of its own, at low priority and first in line when memory
/// runs out. The group is killed when the time is up, when a stop is asked for, when the program itself ends,
/// and when this process or the calling thread dies, however it dies. It inherits no file but its log.
/// Throws std::system_error when it cannot be started.
ProgramEnd run_program(const ProgramCall& call, const std::stop_token& stop);

}  // namespace voidpath::daemon

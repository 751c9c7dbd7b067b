#pragma once

#include "tests/mock_printer/mock_marlin.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

/// The mock firmware behind a pseudo terminal with the pace of a serial wire, in real time: what a host
/// meets.
namespace voidpath::bench {

/// Of a process.
struct CpuUse {
  double user_s = 0, kernel_s = 0;
  double sleeps = 0;  ///< times it gave the processor away to wait
  double total_s() const { return user_s + kernel_s; }
  CpuUse operator-(const CpuUse& before) const {
    return {user_s - before.user_s, kernel_s - before.kernel_s, sleeps - before.sleeps};
  }
};

struct Outcome {
  int exit_code = -1;
  std::uint64_t commands = 0;  ///< executed, the host's own included
  std::uint64_t bytes = 0;     ///< of the print, as they went over the wire
  double stream_s = 0;         ///< between the executions of the first and the last
  std::uint64_t resends = 0;
  std::uint64_t bytes_dropped = 0;
  CpuUse cpu;              ///< what the host said last: of its process, while it printed
  double resident_mb = 0;  ///< its highest
  std::string output;      ///< what it printed
  std::vector<std::string> executed;
  double halted_at_s = -1;  ///< CLOCK_MONOTONIC when M112 was in the terminal
};

/// Runs `host` (a command; `PORT` in it stands for the terminal's path) against a printer until it exits.
/// The print is from the command `first` to the command `last`.
Outcome run_host(const voidpath::test::mock::Options& printer, std::vector<std::string> host,
                 std::string_view first, std::string_view last, double limit_s);

double monotonic_s();
/// Of this process so far.
CpuUse cpu_use();
/// CPU time of one sleep of 3 ms: what the kernel, the machine and its other programs make of an awakening.
double cost_of_sleep_s();
/// From now on this process and its children come before all that is not real-time, so that a busy machine
/// is not mistaken for the wire or the host. False where that is not allowed.
bool take_precedence();

}  // namespace voidpath::bench

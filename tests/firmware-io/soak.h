#pragma once

#include "tests/mock_printer/options.h"

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// Prints through every fault the mock knows, in invented time. What the printer took is compared, line by
/// line and number by number, with what the driver sent and with the file.
namespace voidpath::test {

struct SoakPrint {
  std::string what;  ///< the firmware and its faults, for a report
  bool finished = false;
  bool ended = false;     ///< finished, failed or cancelled, with a reason
  std::string reason;     ///< of a failure
  std::string violation;  ///< what must never happen; empty as it should be
  /// Lines the firmware obeyed though damage had made them something else, which its checks cannot see.
  int invisible = 0;
  bool noticed = false;  ///< by the host, in its record
  int pauses = 0;        ///< until a person came, who let it go on
  double longest_gap_s = 0;
  std::uint64_t resends = 0;
  std::uint64_t bytes_lost = 0;  ///< to a full receive buffer, or while the printer booted
};

/// Hears the whole dialogue: when, who ('>' the host, '<' the printer, '=' what it took), what; S3G's bytes
/// in hexadecimal.
using SoakTrace = std::function<void(double s, char who, std::string_view bytes)>;

/// Prints it: a line each.
void show_dialogue(double s, char who, std::string_view bytes);

struct SoakHooks {
  SoakTrace trace{};
  std::function<std::string(std::string)> to_printer{}, to_host{};  ///< damage what passes
  double read_every_s = 0;                                          ///< a host too busy to read more often
  int pause_at = 0, cancel_at = 0;  ///< the user does, after so many lines of the file; 0: never
};

/// One print of this file on this printer.
SoakPrint play(const mock::Options& options, std::vector<std::string> file, const SoakHooks& hooks);

/// A print, a printer and its faults, drawn by the seed.
SoakPrint soak_print(std::uint64_t seed, const SoakTrace& trace = {});
/// The same of a MakerBot over S3G.
SoakPrint s3g_soak_print(std::uint64_t seed, const SoakTrace& trace = {});
/// Only flipped bytes, both ways, one in 10 kB, on a Marlin at 115200.
SoakPrint noisy_print(std::uint64_t seed, const SoakTrace& trace = {});

}  // namespace voidpath::test

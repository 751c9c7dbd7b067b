#pragma once

#include "firmware-io/firmware_limits.h"

#include <cstdint>
#include <map>
#include <string>
#include <variant>

/// What a printer session tells. Every event carries the session clock's time in seconds.
namespace voidpath::fw {

struct FirmwareInfo {
  std::string name;     ///< FIRMWARE_NAME of M115, e.g. "Marlin 2.1.2"
  std::string machine;  ///< MACHINE_TYPE
  std::string uuid;
  int extruders = 1;                         ///< EXTRUDER_COUNT, or as many as it tells temperatures of
  std::map<std::string, bool> capabilities;  ///< Cap: lines
};

struct Temperature {
  double actual_c = 0;
  double target_c = 0;
};

struct Connected {
  FirmwareInfo firmware;
};
/// How the firmware is set up, once after each Connected and before anything of a print is sent; never where
/// the firmware tells nothing of it.
struct LimitsKnown {
  FirmwareLimits limits;
};
/// The port is gone or silent; a print that ran has failed by this.
struct Disconnected {
  std::string reason;
};
struct Temperatures {
  std::map<std::string, Temperature> sensors;  ///< "T0", "B", ...
};
/// The print's first line goes out.
struct PrintStarted {};
/// The firmware acknowledged the file's line `index`. For moves: queued, not moved.
struct LineDone {
  std::uint32_t index = 0;
  std::uint64_t file_position = 0;
};
/// Waiting for a temperature (M109, M190) began or ended.
struct Heating {
  bool on = false;
};
/// The first motion after heating was sent: measuring starts.
struct MotionStarted {};
/// Streaming stopped or went on: by the user, or by the printer itself (`by_printer`).
struct Paused {
  bool by_printer = false;
  std::string reason;
};
struct Resumed {};
/// All lines acknowledged and the machine at rest (M400).
struct PrintFinished {};
/// Ended on request, heaters off.
struct PrintCancelled {};
/// Ended by a fault, heaters off as far as the printer still listens.
struct PrintFailed {
  std::string reason;
};
/// Text from the firmware worth showing: echo, Error, action notifications.
struct Message {
  std::string text;
  bool asks = false;  ///< a person, who is told the answers that it takes
};
/// Sent every ten seconds of a print and at its end.
struct LinkStats {
  std::uint64_t lines_sent = 0;
  std::uint64_t resends = 0;
  std::uint64_t bytes_sent = 0;
  int window_bytes = 0;
  /// Signs that the printer may have obeyed a damaged line: an ok for a line without a number, an unknown
  /// command, a request for a line already acknowledged. Marlin cannot see every damage. Over S3G: commands
  /// that may have run twice.
  std::uint64_t doubts = 0;

  /// What has been counted since then.
  LinkStats since(const LinkStats& then) const noexcept {
    return {lines_sent - then.lines_sent, resends - then.resends, bytes_sent - then.bytes_sent, window_bytes,
            doubts - then.doubts};
  }
};

struct Event {
  double at_s = 0;
  std::variant<Connected, Disconnected, Temperatures, PrintStarted, LineDone, Heating, MotionStarted, Paused,
               Resumed, PrintFinished, PrintCancelled, PrintFailed, Message, LinkStats, LimitsKnown>
      what;
};

inline bool ends_print(const decltype(Event::what)& what) noexcept {
  return std::holds_alternative<PrintFinished>(what) || std::holds_alternative<PrintCancelled>(what) ||
         std::holds_alternative<PrintFailed>(what);
}

}  // namespace voidpath::fw

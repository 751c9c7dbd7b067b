#pragma once

#include "firmware-io/event.h"

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

/// The lines a Marlin-class firmware says, as values. Pure; whatever cannot be understood is Other.
namespace voidpath::fw::marlin {

using Sensors = std::map<std::string, Temperature>;

struct Ok {
  std::optional<std::uint32_t> line;  ///< ADVANCED_OK, or Repetier's `ok 123`
  std::optional<int> planner_free;
  std::optional<int> queue_free;
  Sensors sensors;  ///< of M105's answer
};
/// The firmware wants everything again from this line on.
struct Resend {
  std::uint32_t line = 0;
};
struct Error {
  enum class Kind {
    framing,  ///< a damaged or misplaced line; a Resend follows as a rule
    fatal,    ///< the firmware has stopped or is about to
    refused,  ///< a command of weight was not carried out: `!!`, or a levelling that failed
    other,    ///< a complaint about one command
  };
  Kind kind = Kind::other;
  std::string text;
  std::optional<std::uint32_t> last_line;  ///< framing: the last line it took
};
struct Busy {
  bool for_user = false;  ///< waits for a person, not for the machine
  std::string why;
};
/// The firmware booted: positions, temperatures and line numbers are lost.
struct Start {};
/// MeatPack's state, after each of its commands.
struct PackState {
  bool on = false;
  bool no_spaces = false;
};
/// More was sent than the receive buffer holds.
struct Overrun {
  std::string text;
};
/// Queue and receive buffer are empty (Repetier, NO_TIMEOUTS).
struct Wait {};
struct TemperatureReport {
  Sensors sensors;
  bool waiting = false;  ///< printed by a command that waits for a temperature
};
/// `//action:<name> <argument>`
struct Action {
  std::string name;
  std::string argument;
};
struct Capability {
  std::string name;
  bool on = false;
};
struct Firmware {
  FirmwareInfo info;
};
struct Echo {
  std::string text;
};
struct Other {
  std::string text;
};

using Reply = std::variant<Ok, Resend, Error, Busy, Start, Wait, PackState, Overrun, TemperatureReport,
                           Action, Capability, Firmware, Echo, Other>;

/// `line` without its line end.
Reply parse_reply(std::string_view line);

/// `T:210.5 /210.0 B:60.0 /60.0 @:64`: the first value of each sensor. A lone T, or T beside T1, is T0.
Sensors parse_temperatures(std::string_view text);

}  // namespace voidpath::fw::marlin

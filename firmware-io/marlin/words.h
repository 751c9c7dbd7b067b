#pragma once

#include <string>
#include <string_view>

/// As much of a command's meaning as streaming needs. Pure.
namespace voidpath::fw::marlin {

struct Word {
  char letter = 0;  ///< capital; 0 when the text begins with none
  int number = -1;  ///< -1: none
  bool operator==(const Word&) const = default;
};

/// The first word: G28 of "G28.1 X0".
Word first_word(std::string_view command) noexcept;

/// Blocks until a temperature is reached: M109, M190, M116, M191, M192, M193.
bool is_heating_wait(std::string_view command) noexcept;
/// Homes or probes the bed: G28, G29, G30, G33, G34, G76, G80. Acknowledged when it has ended.
bool is_homing(std::string_view command) noexcept;
/// May wait for a person at the panel: M125, M226, M600, M601, M701, M702.
bool may_wait_for_person(std::string_view command) noexcept;
/// Wants one, to change the filament or at the file's wish: M226, M600, M601.
bool wants_person(std::string_view command) noexcept;
/// A word of several letters, as Klipper's macros and extended commands: whatever it heats, homes and moves
/// has ended when its ok comes.
bool is_macro(std::string_view command) noexcept;
/// Words to a firmware that reads on when it has paused itself and parked.
struct Parking {
  std::string_view resume;  ///< back to the print's place
  std::string_view forget;  ///< this print does not go on
  bool knows_m108;          ///< which ends a wait at its panel
};
/// Of Klipper's PAUSE, and Prusa's M601 and its panel; nullptr where the firmware waits in place.
const Parking* parking_of(std::string_view firmware) noexcept;
/// May take minutes before its ok.
bool is_long(std::string_view command) noexcept;
/// Moves an axis or the filament towards a given place: G0 to G3 and G5 with an axis word. Homing is none.
bool is_motion(std::string_view command) noexcept;
/// M113: how often the firmware says that it is busy, by which its silences are judged.
bool sets_keepalive(std::string_view command) noexcept;
/// M155 S: whether it tells temperatures unasked, and how often.
bool sets_reports(std::string_view command) noexcept;
/// M155 S0.
bool ends_reports(std::string_view command) noexcept;
/// M0, M1 and M25, which means a print from the card: the host pauses instead of the firmware.
bool is_pause(std::string_view command) noexcept;
/// Would be taken for a new line number: Marlin looks for M110 anywhere in a numbered line, and a packed move
/// has lost its blanks.
bool sets_line_number(std::string_view command);
/// Works only at once, without a line number, ahead of what is queued: M108, M112, M410, M876.
bool is_out_of_band(std::string_view command) noexcept;

}  // namespace voidpath::fw::marlin

#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace voidpath::fw::marlin {

/// Of a place on an absolute axis: half a micrometre at the most is lost, and nothing adds up.
inline constexpr std::size_t kPlaceDecimals = 3;

/// What of a G-code file's line goes to the printer: sanitised; without a line number and checksum of the
/// file's own; command letters, and the axis letters of G lines, as capitals; numbers shortened to 5 decimals
/// where the line would otherwise be too long. Empty for comments, program markers (%), host commands (@)
/// and M110, even in a text, which would upset our own numbering.
/// Throws std::runtime_error when the line cannot be made short enough, or holds zero bytes.
std::string file_command(std::string_view raw);

/// A move (G0 to G3) of a command from file_command() in fewer bytes: without zeros that say nothing, blanks
/// in a row and needless signs; where `absolute_mm` (G90 and G21 hold), X, Y and Z of a straight move at the
/// nearest thousandth; then `*rounded` is set where that changed one. All other values stay exactly what they
/// were. Anything else, and whatever it does not understand in full, comes back as it is.
std::string trim_move(std::string_view line, bool absolute_mm, bool* rounded = nullptr);

/// The value of X or Y in a straight move as it is written; empty when it has none.
std::string place_of(std::string_view move, char axis);

}  // namespace voidpath::fw::marlin

#pragma once

#include <string>
#include <string_view>

namespace voidpath::fw::marlin {

/// What of a G-code file's line goes to the printer: sanitised; without a line number and checksum of the
/// file's own; command letters, and the axis letters of G lines, as capitals; numbers shortened to 5 decimals
/// where the line would otherwise be too long. Empty for comments, program markers (%), host commands (@)
/// and M110, which would upset our own numbering.
/// Throws std::runtime_error when the line cannot be made short enough, or holds zero bytes.
std::string file_command(std::string_view raw);

}  // namespace voidpath::fw::marlin

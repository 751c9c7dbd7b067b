#pragma once

#include <filesystem>
#include <string>

namespace voidpath::daemon {

enum class InputKind { none, model, gcode };

/// What a dropped file's name promises. Hidden names, and names that programs give to what they have not
/// finished (".part", "~", ".crdownload", ...), are none.
InputKind input_kind(const std::filesystem::path& file);

/// Whether any process holds the file open for writing. Asks for a read lease, which the kernel grants only
/// where there is no writer; where leases are not to be had, looks through /proc, and so sees the processes
/// this one may see. False when nothing can be told.
bool open_for_writing(const std::filesystem::path& file) noexcept;

/// What the file's own content says about its end.
enum class Completeness {
  complete,
  unknown,    ///< the format has no mark, and nothing looks odd
  truncated,  ///< the file promises more than it holds: counts, end marks, an unfinished last line
};
Completeness completeness(const std::filesystem::path& file) noexcept;

}  // namespace voidpath::daemon

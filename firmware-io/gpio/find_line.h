#pragma once

#include "firmware-io/gpio/pins.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// What both versions of libgpiod need beside the library: which chip and line are meant, and what to say
/// when that fails.
namespace voidpath::fw::gpiod {

struct ChipFacts {
  std::string name;
  std::string label;
  unsigned lines = 0;
};

/// How a version of the library looks at a chip.
struct ChipReader {
  /// Empty with errno set where the device cannot be opened.
  std::function<std::optional<ChipFacts>(const std::string& path)> facts;
  /// The offset of the line of that name; empty: the chip has none.
  std::function<std::optional<unsigned>(const std::string& path, const std::string& line)> offset;
};

struct FoundLine {
  std::string path;
  unsigned offset = 0;
};

/// Throws PinError.
FoundLine find_line(const PinOptions& pin, const ChipReader& reader);

/// For a line that was found and refused: `error` is errno. Throws PinError.
[[noreturn]] void refuse(const PinOptions& pin, int error);

}  // namespace voidpath::fw::gpiod

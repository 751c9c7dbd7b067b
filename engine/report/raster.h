#pragma once

#include "engine/report/part_picture.h"
#include "engine/report/view.h"

#include <cstdint>
#include <string>
#include <vector>

namespace voidpath::report {

/// What a pixel shows. Each kind has its own ramp of colours.
enum class Ink : std::uint8_t { nothing, part, overhang, part_behind_support, support, shadow };
inline constexpr int kInks = 6;
/// Shades of a ramp, darkest first: steps too small to be seen as bands.
inline constexpr int kShades = 26;

/// A drawing in kinds and shades, row 0 at the top.
struct Painting {
  int width = 0, height = 0;
  std::vector<std::uint8_t> pixels;  ///< ink * kShades + shade

  std::uint8_t at(int i, int j) const {
    return pixels[static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(i)];
  }
};

/// Where a painting lies in the view: its upper left corner and its resolution.
struct Window {
  double left_mm = 0, top_mm = 0;
  double px_per_mm = 1;
  int width = 0, height = 0;
};

/// Hidden surfaces removed by depth, edges of the part darkened.
Painting paint(const Standing& part, const View& view, const Window& window);

/// One <path> for each colour present, made of strokes along the rows, over an underlay of the part's
/// outline. In pixels of the painting.
std::string rows_of(const Painting& painting);

}  // namespace voidpath::report

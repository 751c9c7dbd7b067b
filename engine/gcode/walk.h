#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

/// Where the head goes, without times: for whoever checks or measures the geometry of a file.
namespace voidpath::gcode {

using Position = std::array<double, 3>;

/// One movement; of an arc its two ends. mm.
struct Step {
  Position from{};
  Position to{};
  double pushed_mm = 0;        ///< filament; negative: drawn back
  bool in_layers = false;      ///< a comment has opened the first layer
  const std::string& feature;  ///< the last `;TYPE:` and its kin; lives during the call

  bool flat() const { return from[2] == to[2]; }
  bool moves_xy() const { return from[0] != to[0] || from[1] != to[1]; }
};

/// Calls `on_step` for every G0 to G3, in order. Positions follow G90/G91, M82/M83, G92 and G20/G21; homing
/// puts an axis to 0. Throws std::runtime_error when the stream fails or what `on_step` throws.
void walk(std::istream& in, const std::function<void(const Step&)>& on_step);

/// The box around what is printed.
struct Extents {
  bool any = false;
  Position min{};
  Position max{};

  void add(const Position& p);
};

struct PrintedExtents {
  Extents all;          ///< ends of beads within the layers: start G-code's purge lines are not among them
  Extents outer_walls;  ///< of those, the outermost walls, where comments tell
};

/// Throws std::runtime_error naming the file when it cannot be read.
PrintedExtents printed_extents(const std::filesystem::path& file);

}  // namespace voidpath::gcode

#pragma once

#include <optional>
#include <string_view>

/// What slicers say in comments. PrusaSlicer and its kin (";TYPE:", ";LAYER_CHANGE", ";Z:"), Cura
/// (";TYPE:", ";LAYER:n"), Bambu Studio and OrcaSlicer ("; FEATURE:", "; CHANGE_LAYER", "; Z_HEIGHT:"),
/// Simplify3D ("; layer 2, Z = 0.4", "; feature outer perimeter"), ideaMaker (";PRINTING:").
namespace voidpath::gcode {

struct Remark {
  enum class Kind { none, layer, height, feature };
  Kind kind = Kind::none;
  std::string_view feature;
  std::optional<double> z_mm;
};

/// `comment` is the text after the ';'.
Remark read_comment(std::string_view comment);

}  // namespace voidpath::gcode

#pragma once

#include <istream>
#include <string>
#include <vector>

/// G-code as what lies on the bed afterwards, read by the plain rules of the language and none of the
/// engine's code: what the checker finds must not rest on what it checks.
namespace voidpath::fidelity {

enum class Kind { wall, fill, bridge, support, brim };

/// A straight strand. mm, plate coordinates. The width is what the extruded volume gives at the layer's
/// height, for a rectangle with half-round ends; of a bridge, for a round strand.
struct Bead {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double width = 0;
  Kind kind = Kind::fill;
};

struct Layer {
  double top = 0;     ///< `;Z:` of the file, mm
  double height = 0;  ///< `;HEIGHT:`
  std::vector<Bead> beads;
  double volume = 0;   ///< of all material pressed out, mm³
  double implied = 0;  ///< by the lengths and the widths and heights the comments tell, mm³
};

struct Print {
  std::vector<Layer> layers;
  /// Where E, a coordinate or a comment could not be understood: line and what.
  std::vector<std::string> complaints;
};

/// `flow`: the filament's extrusion multiplier, whose share is taken out of every volume.
Print read_print(std::istream& in, double filament_diameter, double flow);

}  // namespace voidpath::fidelity

#pragma once

#include <istream>
#include <string>
#include <vector>

/// G-code as what lies on the bed afterwards, read by the plain rules of the language and none of the
/// engine's code: what the checker finds must not rest on what it checks.
namespace voidpath::fidelity {

/// Support that is printed densely to hold the part is a roof.
enum class Kind { wall, fill, bridge, support, roof, brim };

inline bool is_support(Kind k) { return k == Kind::support || k == Kind::roof; }

/// A straight strand. mm, plate coordinates. The width is what the extruded volume gives at the strand's
/// height, for a rectangle with half-round ends; of one as high as it is wide, for a round one.
struct Bead {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double width = 0;
  double height = 0;  ///< from what it lies on up to the nozzle, at its middle; of a round one its diameter
  double top = 0;     ///< of the nozzle, at its middle
  Kind kind = Kind::fill;
  bool round = false;   ///< printed into air
  bool climbs = false;  ///< the nozzle rises along it
};

struct Layer {
  double top = 0;     ///< `;Z:` of the file, mm
  double height = 0;  ///< the first `;HEIGHT:` after it
  std::vector<Bead> beads;
  double volume = 0;   ///< of all material pressed out, mm³
  double implied = 0;  ///< by the lengths and the widths and heights the comments tell, mm³
};

struct Print {
  std::vector<Layer> layers;
  /// Where E, a coordinate or a comment could not be understood: line and what.
  std::vector<std::string> complaints;
};

/// A `;HEIGHT:` later in a layer is that of the strands after it. A round that climbs lies on the round of
/// the layer below, at the same share of its way, and a level one that goes on from it in its layer on the
/// climbing one; what follows apart is level, as in any layer.
/// `flow`: the filament's extrusion multiplier, whose share is taken out of every volume.
Print read_print(std::istream& in, double filament_diameter, double flow);

}  // namespace voidpath::fidelity

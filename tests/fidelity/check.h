#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "tests/fidelity/beads.h"

#include <string>

/// What was sliced against what was asked for: the printed strands, rasterised layer by layer, beside exact
/// sections of the mesh.
namespace voidpath::fidelity {

struct Rules {
  double line_width = 0.45;      ///< mm
  double infill_density = 0.15;  ///< 0 to 1
  double support_density = 0.15;
  double support_angle_deg = 45;  ///< what leans out further must be held
  double support_z_gap = 0.2;     ///< mm
  double largest_pixel = 0.05;    ///< mm
  std::size_t most_pixels = 2'000'000;
};

/// The worst that was found, and where: "layer 12 (z 2.4) at (103.2, 88.1)".
struct Worst {
  double value = 0;
  std::string where;
};

struct Findings {
  std::size_t layers = 0;
  double pixel = 0;  ///< mm
  Worst outside;     ///< mm that material reaches beyond the part's section
  Worst uncovered;   ///< of a layer's area without material, as a share of what is allowed; solid prints only
  Worst top_hole;    ///< mm: half the width of the widest gap in a surface seen from above
  Worst bottom_hole;    ///< the same from below
  Worst loose;          ///< mm of strand over nothing with a free end
  Worst unannounced;    ///< mm of strand over nothing, held at both ends, printed as if something were below
  double loose_mm = 0;  ///< all of it
  double unannounced_mm = 0;
  double length_mm = 0;     ///< of all strands of the part
  double volume_ratio = 1;  ///< extruded / implied by the paths' widths and heights
};

/// `mesh` in plate coordinates, standing at z = 0.
/// Surfaces: a layer's area less the next one's, without a line width at its border and the pixels' error.
/// Held: within the lean that the angle allows of strands one layer down; over sparse infill and support as
/// far as their lines are apart; by the plate, and by the part below a gap of its own, where no support
/// layer with its gap fits between.
Findings check(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules);

}  // namespace voidpath::fidelity

#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "tests/fidelity/beads.h"
#include "tests/fidelity/rules.h"

#include <string>
#include <vector>

/// What was sliced against what was asked for: the printed strands, rasterised layer by layer, beside exact
/// sections of the mesh.
namespace voidpath::fidelity {

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
  Worst support_loose;  ///< mm of a support's strand over nothing with a free end
  Worst support_span;   ///< the same, held at both ends
  Worst wall_gap;       ///< of a vase: mm between where its wall should be and the material nearest to it
  Worst brim_inside;    ///< mm that brim reaches into the part
  Worst brim_away;      ///< mm from a point of skirt or brim to the part or support nearest to it
  Worst inset;          ///< mm by which a solid print's layer stays inside its outline, in the mean
  double loose_mm = 0;  ///< all of it
  double unannounced_mm = 0;
  double length_mm = 0;                 ///< of all strands of the part
  double support_mm = 0;                ///< and of support
  double brim_mm = 0;                   ///< and of skirt and brim
  double volume_ratio = 1;              ///< extruded / implied by the paths' widths and heights
  std::vector<std::string> complaints;  ///< of reading
};

/// `mesh` in plate coordinates, standing at the rules' ground.
/// Surfaces: a layer's area less the next one's, without a line width at its border and the pixels' error.
/// Held: as Ground says; with support from the plate alone, only what support that stands straight up from
/// the plate could hold. Of a vase the wall alone is looked at above its floor: it may lie anywhere between
/// its own layer's outline and that of the layer below, and nothing is to be inside.
Findings check(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules);

}  // namespace voidpath::fidelity

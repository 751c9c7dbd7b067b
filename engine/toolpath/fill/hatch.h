#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// Parallel lines over an area, joined at their ends along the border where that is short.
struct HatchOptions {
  double angle_rad = 0;   ///< direction of the lines, counter-clockwise from x
  double spacing_mm = 1;  ///< between neighbouring lines
  /// Rows are spread evenly from border to border, and the spacing changes a little for it. Otherwise rows
  /// lie on a lattice through the plate's origin, so that they meet from layer to layer.
  bool fit = false;
  double max_link_mm = 0;  ///< longest stretch along the border that joins two lines; 0: none
  /// Fitted rows lie no further apart than this many spacings.
  double max_stretch = 1.15;
};

struct Hatch {
  geom::Polylines lines;
  double spacing_mm = 0;  ///< as used
};

/// Lines run from border to border of `domain`, which holds their centre lines; links follow the border.
/// The order is that of walking through the area row by row.
Hatch hatch(const geom::Regions& domain, const HatchOptions& options);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/geom/polygon.h"

#include <vector>

namespace voidpath::slice {

/// Where one printed layer lies, mm above the plate.
struct LayerSpan {
  double bottom_mm = 0;
  double top_mm = 0;  ///< the nozzle's height while it prints the layer
  double height_mm() const { return top_mm - bottom_mm; }
  double cut_mm() const { return 0.5 * (bottom_mm + top_mm); }  ///< where the mesh is cut
};

/// One layer of the part: its span and the filled areas of the cut, in plate coordinates (nm).
struct Layer {
  LayerSpan span;
  geom::Regions regions;
};

/// From the plate up, without gaps in z.
using LayerStack = std::vector<Layer>;

}  // namespace voidpath::slice

#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/walls/perimeters.h"

#include <cstdint>
#include <vector>

namespace voidpath::toolpath {

/// A contour at a fixed distance from the border, and its neighbours in a spanning tree of contours that lie
/// side by side.
struct Contour {
  geom::Ring ring;
  std::uint32_t level = 0;  ///< 0: along the border
  std::vector<std::uint32_t> children;
};

/// Contours one spacing apart that fill a region, as trees: most have one, rooted in the outermost contour;
/// a part that only hangs together by less than two beads has its own.
struct ContourForest {
  std::vector<Contour> contours;
  std::vector<std::uint32_t> roots;
  geom::Regions gaps;  ///< what no contour covers
};

/// Of a region of centre lines: the outermost contours run along its border.
ContourForest contour_forest(const geom::Region& domain, const BeadSize& bead);

/// The point of the ring nearest to p, and where it lies: length from the ring's first vertex, nm.
struct OnRing {
  geom::Point at;
  double along = 0;
  double distance = 0;
};
OnRing nearest_on_ring(const geom::Ring& ring, const geom::Point& p);

}  // namespace voidpath::toolpath

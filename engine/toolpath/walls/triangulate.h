#pragma once

#include "engine/geom/polygon.h"

#include <array>
#include <cstdint>
#include <vector>

namespace voidpath::toolpath {

/// Triangles over a region's own vertices. Side k of a triangle runs from corner k to corner k + 1.
struct Triangulation {
  static constexpr std::uint32_t kBorder = 0xffffffff;
  struct Triangle {
    std::array<std::uint32_t, 3> corner;     ///< counter-clockwise
    std::array<std::uint32_t, 3> neighbour;  ///< across each side; kBorder where the region ends
  };
  std::vector<geom::Point> points;
  std::vector<Triangle> triangles;
};

/// Constrained Delaunay triangulation: holes are joined to the outer ring by cuts, ears are clipped, sides
/// flipped until none can be improved (Lawson). For slivers: every ear looks at the vertices in its
/// range of x. Empty where the region is degenerate.
Triangulation triangulate(const geom::Region& region);

}  // namespace voidpath::toolpath

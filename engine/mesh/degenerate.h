#pragma once

#include "engine/mesh/edges.h"

namespace voidpath::mesh {

/// Height over longest side below which a facet counts as having no area: what rounding leaves of three
/// points on a line.
inline constexpr double kNoAreaRatio = 1e-10;

/// A corner used twice, or three corners on a line.
inline bool has_no_area(const TriangleMesh& m, const Triangle& t) {
  if (has_repeated_corner(t)) return true;
  const Vec3 a = m.vertices[t[1]] - m.vertices[t[0]];
  const Vec3 b = m.vertices[t[2]] - m.vertices[t[0]];
  const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
  return a.cross(b).norm() <= kNoAreaRatio * longest;
}

}  // namespace voidpath::mesh

#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace voidpath::mesh {

/// Twice the area of a closed ring as a vector along its normal (Newell).
Vec3 ring_vector_area(std::span<const Vec3> ring);

/// Cuts a ring of at least three points, concave ones too, into triangles of its own points by clipping
/// ears in its best plane; winding kept, n - 2 triangles. Rings that cross themselves in that plane are
/// cut as well as they can be. Time is at most quadratic, and linear beyond a thousand points.
/// Returns whether every triangle was a proper ear.
bool triangulate(std::span<const Vec3> ring, std::vector<Triangle>& out);

/// The cut with the least area, for rings that lie in no plane. Time is cubic: for short rings.
void triangulate_least_area(std::span<const Vec3> ring, std::vector<Triangle>& out);

}  // namespace voidpath::mesh

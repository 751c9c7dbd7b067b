#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <vector>

namespace voidpath::orient {

/// Triangles of the convex hull, counter-clockwise seen from outside, by quickhull (Barber, Dobkin, Huhdanpaa
/// 1996). Points within a millionth of the cloud's size of a facet count as on it. Empty when all points lie
/// in one plane. The order depends on the input alone.
std::vector<mesh::Triangle> convex_hull(const std::vector<geom::Vec3>& points);

}  // namespace voidpath::orient

#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/geom/vec.h"

namespace voidpath::mesh {

using geom::Vec3;
using Triangle = std::array<std::uint32_t, 3>;

/// Indexed triangles, mm, z up; counter-clockwise seen from outside. Every index is valid and every
/// coordinate finite: import and repair see to it, everything after relies on it.
struct TriangleMesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
};

struct Bounds {
  Vec3 min = Vec3::Zero();
  Vec3 max = Vec3::Zero();
  Vec3 size() const { return max - min; }
};

Bounds bounds(const TriangleMesh& mesh);
/// Signed volume in mm³ (divergence theorem); positive when the faces look outwards.
double volume(const TriangleMesh& mesh);
/// Surface in mm².
double surface_area(const TriangleMesh& mesh);
/// Centre of mass of the solid; of the bounding box where the volume is nil.
Vec3 centroid(const TriangleMesh& mesh);

/// The mesh turned so that `direction` (unit, model space) points along +z, by rotation_to_up(), then
/// moved so that its lowest point is at z = 0 and its bounding box is centred on x = y = 0.
TriangleMesh turned(const TriangleMesh& mesh, const Vec3& direction);
TriangleMesh rotated(const TriangleMesh& mesh, const geom::Quaternion& q);
/// The shortest turn that takes `direction` to +z; for -z, half a turn about x.
geom::Quaternion rotation_to_up(const Vec3& direction);

}  // namespace voidpath::mesh

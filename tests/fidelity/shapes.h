#pragma once

#include "tests/support/meshes.h"

#include <algorithm>

/// Small parts that show much at once. mm; they stand on z = 0.
namespace voidpath::fidelity {

/// A wide foot, a post and a wider cap: below the cap lies the foot, and beyond it the plate.
inline mesh::TriangleMesh spool() {
  const auto on = [](const mesh::TriangleMesh& m, double x, double y, double z) {
    return test::moved(m, x, y, z);
  };
  return test::joined(
      test::joined(on(test::box(11, 11, 1.6), -5.5, -5.5, 0), on(test::box(4, 4, 6), -2, -2, 0)),
      on(test::box(16, 13, 1.6), -8, -6.5, 5.6));
}

/// A ball on a post.
inline mesh::TriangleMesh ball() {
  return test::joined(test::moved(test::sphere(5, 20, 32), 0, 0, 1.6), test::cylinder(1.6, 4, 24));
}

/// A round block whose wall leans out.
inline mesh::TriangleMesh beaker() {
  mesh::TriangleMesh out = test::cylinder(6, 5, 48);
  for (auto& v : out.vertices)
    if (v.z() > 1) v.x() *= 1.2, v.y() *= 1.2;
  return out;
}

/// A round block with a fin thinner than a line, and a sheet as thin beside it.
inline mesh::TriangleMesh finned() {
  const auto sheet = [](double x, double y) { return test::moved(test::box(8, 0.3, 4), x, y, 0); };
  return test::joined(test::joined(test::cylinder(5, 4, 48), sheet(2, -0.15)), sheet(0, 7));
}

/// A block with a round hole, and a thin wall beside it.
inline mesh::TriangleMesh drilled() {
  mesh::TriangleMesh hole = test::cylinder(2.5, 4, 48);
  for (auto& t : hole.triangles) std::swap(t[0], t[1]);
  return test::joined(test::joined(test::moved(test::box(12, 10, 4), -6, -5, 0), hole),
                      test::moved(test::box(0.8, 10, 4), 8, -5, 0));
}

}  // namespace voidpath::fidelity

#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstdint>
#include <vector>

namespace voidpath::mesh {

/// Numbers points by their exact coordinates (-0 equals 0) in the order they first appear.
class VertexTable {
 public:
  explicit VertexTable(std::size_t expected = 0);
  std::uint32_t add(const Vec3& point);
  std::size_t size() const { return points_.size(); }
  std::vector<Vec3> take() { return std::move(points_); }

 private:
  void grow(std::size_t slots);

  std::vector<Vec3> points_;
  std::vector<std::uint32_t> slots_;  ///< open addressing; kFree or an index into points_
};

/// Merges corners of equal coordinates; vertices in the order the facets first use them, unused ones gone.
TriangleMesh weld(const TriangleMesh& mesh);

/// Drops vertices no facet uses; the others keep their order.
void drop_unused_vertices(TriangleMesh& mesh);

}  // namespace voidpath::mesh

#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace voidpath::mesh {

/// Finds the facets a vertical line goes through, in logarithmic time a facet. Refers to the mesh.
class RayTree {
 public:
  explicit RayTree(const TriangleMesh& mesh);

  /// Calls hit(facet, above, up) for each facet on the vertical line through p: whether it is met above p,
  /// and whether it looks upwards. Upright facets are not met. A line through a common side of two facets
  /// meets one of them.
  void along_z(const Vec3& p, const std::function<void(std::uint32_t facet, bool above, bool up)>& hit) const;

 private:
  struct Node {
    double low[2], high[2];    ///< xy box
    std::uint32_t begin, end;  ///< range in order_ of a leaf
    std::uint32_t right;       ///< inner nodes: the left child follows at once; 0 in leaves
  };
  void build(std::uint32_t begin, std::uint32_t end, const std::vector<Eigen::Vector2d>& centres);

  const TriangleMesh& mesh_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace voidpath::mesh

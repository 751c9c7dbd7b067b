#include "engine/mesh/ray_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace voidpath::mesh {

namespace {

constexpr std::uint32_t kLeafFacets = 8;

/// On which side of the edge a-b the point lies, seen from above; the same answer, mirrored, for b-a, so
/// that neighbours never both claim or both miss a point.
bool left_of(const TriangleMesh& m, std::uint32_t a, std::uint32_t b, const Vec3& p) {
  const bool swapped = a > b;
  const Vec3& s = m.vertices[swapped ? b : a];
  const Vec3& e = m.vertices[swapped ? a : b];
  const double side = (e.x() - s.x()) * (p.y() - s.y()) - (e.y() - s.y()) * (p.x() - s.x());
  return (side >= 0) != swapped;
}

}  // namespace

RayTree::RayTree(const TriangleMesh& mesh) : mesh_(mesh), order_(mesh.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<Eigen::Vector2d> centres(mesh.triangles.size());
  for (std::size_t f = 0; f < centres.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    centres[f] = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]).head<2>();
  }
  nodes_.reserve(2 * mesh.triangles.size() / kLeafFacets + 2);
  if (!order_.empty()) build(0, static_cast<std::uint32_t>(order_.size()), centres);
}

void RayTree::build(std::uint32_t begin, std::uint32_t end, const std::vector<Eigen::Vector2d>& centres) {
  const std::size_t me = nodes_.size();
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Node node{{kFar, kFar}, {-kFar, -kFar}, begin, end, 0};
  for (std::uint32_t i = begin; i < end; ++i) {
    for (std::uint32_t v : mesh_.triangles[order_[i]]) {
      for (int k = 0; k < 2; ++k) {
        node.low[k] = std::min(node.low[k], mesh_.vertices[v][k]);
        node.high[k] = std::max(node.high[k], mesh_.vertices[v][k]);
      }
    }
  }
  nodes_.push_back(node);
  if (end - begin <= kLeafFacets) return;
  const int axis = node.high[0] - node.low[0] >= node.high[1] - node.low[1] ? 0 : 1;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis]
                                                                 : a < b;
                   });
  build(begin, middle, centres);
  nodes_[me].right = static_cast<std::uint32_t>(nodes_.size());
  build(middle, end, centres);
}

void RayTree::along_z(const Vec3& p, const std::function<void(std::uint32_t, bool, bool)>& hit) const {
  std::vector<std::uint32_t> todo;
  if (!nodes_.empty()) todo.push_back(0);
  while (!todo.empty()) {
    const std::uint32_t at = todo.back();
    todo.pop_back();
    const Node& node = nodes_[at];
    if (p.x() < node.low[0] || p.x() > node.high[0] || p.y() < node.low[1] || p.y() > node.high[1]) continue;
    if (node.right != 0) {
      todo.push_back(node.right);
      todo.push_back(at + 1);
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const Triangle& t = mesh_.triangles[order_[i]];
      const bool side = left_of(mesh_, t[0], t[1], p);
      if (side != left_of(mesh_, t[1], t[2], p) || side != left_of(mesh_, t[2], t[0], p)) continue;
      const Vec3& a = mesh_.vertices[t[0]];
      const Vec3 n = (mesh_.vertices[t[1]] - a).cross(mesh_.vertices[t[2]] - a);
      if (n.z() == 0) continue;
      const double z = a.z() - (n.x() * (p.x() - a.x()) + n.y() * (p.y() - a.y())) / n.z();
      hit(order_[i], z > p.z(), side);
    }
  }
}

}  // namespace voidpath::mesh

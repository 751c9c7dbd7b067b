#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace voidpath::mesh {

/// One side of a facet: from corner slot % 3 of facet slot / 3 to the next corner.
struct EdgeUse {
  std::uint32_t high;  ///< the larger of its two vertices
  std::uint32_t slot;
};

inline std::uint32_t facet_of(std::uint32_t slot) { return slot / 3; }
inline std::uint32_t edge_begin(const TriangleMesh& m, std::uint32_t slot) {
  return m.triangles[slot / 3][slot % 3];
}
inline std::uint32_t edge_end(const TriangleMesh& m, std::uint32_t slot) {
  return m.triangles[slot / 3][(slot % 3 + 1) % 3];
}
/// The corner across the side.
inline std::uint32_t opposite(const TriangleMesh& m, std::uint32_t slot) {
  return m.triangles[slot / 3][(slot % 3 + 2) % 3];
}
/// A corner used twice: such a facet has no sides worth counting.
inline bool has_repeated_corner(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Which facets use which edge. Facets with a repeated corner are left out.
class EdgeTable {
 public:
  explicit EdgeTable(const TriangleMesh& mesh);

  /// Calls visit(low, high, uses) for every edge, in order of its vertices; uses in order of facets.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t low = 0; low + 1 < begin_.size(); ++low) {
      for (std::size_t i = begin_[low]; i < begin_[low + 1];) {
        std::size_t j = i + 1;
        while (j < begin_[low + 1] && uses_[j].high == uses_[i].high) ++j;
        visit(static_cast<std::uint32_t>(low), uses_[i].high, std::span(uses_.data() + i, j - i));
        i = j;
      }
    }
  }

  /// Sides used by one facet.
  std::vector<std::uint32_t> open_slots() const;
  /// The directed edges (from, to) missing for every edge to be walked as often one way as the other. They
  /// always make up rings. None are missing in a mesh that bounds a solid.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> missing_sides(const TriangleMesh& mesh) const;

 private:
  std::vector<std::uint32_t> begin_;  ///< of each low vertex in uses_
  std::vector<EdgeUse> uses_;
};

/// Disjoint sets; the smallest member stands for its set.
class UnionFind {
 public:
  explicit UnionFind(std::size_t n);
  std::uint32_t find(std::uint32_t i);
  /// Whether they were apart.
  bool unite(std::uint32_t a, std::uint32_t b);

 private:
  std::vector<std::uint32_t> parent_;
};

/// For each facet the earliest facet with the same three corners (itself when it is the first), and whether
/// that one is wound the other way.
struct Twins {
  std::vector<std::uint32_t> first;
  std::vector<bool> reversed;
};
Twins find_twins(const TriangleMesh& mesh, const EdgeTable& edges);

}  // namespace voidpath::mesh

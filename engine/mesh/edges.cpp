#include "engine/mesh/edges.h"

#include <numeric>

namespace voidpath::mesh {

EdgeTable::EdgeTable(const TriangleMesh& mesh) : begin_(mesh.vertices.size() + 1, 0) {
  const auto low = [](std::uint32_t a, std::uint32_t b) { return std::min(a, b); };
  for (const Triangle& t : mesh.triangles) {
    if (has_repeated_corner(t)) continue;
    for (std::size_t k = 0; k < 3; ++k) ++begin_[low(t[k], t[(k + 1) % 3]) + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  uses_.resize(begin_.back());
  std::vector<std::uint32_t> at(begin_.begin(), begin_.end() - 1);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    if (has_repeated_corner(t)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      uses_[at[low(a, b)]++] = {std::max(a, b), static_cast<std::uint32_t>(3 * f + k)};
    }
  }
  for (std::size_t v = 0; v + 1 < begin_.size(); ++v) {
    std::sort(uses_.begin() + begin_[v], uses_.begin() + begin_[v + 1],
              [](const EdgeUse& a, const EdgeUse& b) {
                return a.high != b.high ? a.high < b.high : a.slot < b.slot;
              });
  }
}

std::vector<std::uint32_t> EdgeTable::open_slots() const {
  std::vector<std::uint32_t> open;
  for_each([&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses) {
    if (uses.size() == 1) open.push_back(uses[0].slot);
  });
  return open;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> EdgeTable::missing_sides(
    const TriangleMesh& mesh) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> missing;
  for_each([&](std::uint32_t low, std::uint32_t high, std::span<const EdgeUse> uses) {
    int net = 0;
    for (const EdgeUse& u : uses) net += edge_begin(mesh, u.slot) == low ? 1 : -1;
    for (; net > 0; --net) missing.emplace_back(high, low);
    for (; net < 0; ++net) missing.emplace_back(low, high);
  });
  return missing;
}

UnionFind::UnionFind(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0u); }

std::uint32_t UnionFind::find(std::uint32_t i) {
  while (parent_[i] != i) {
    parent_[i] = parent_[parent_[i]];
    i = parent_[i];
  }
  return i;
}

bool UnionFind::unite(std::uint32_t a, std::uint32_t b) {
  a = find(a);
  b = find(b);
  if (a == b) return false;
  parent_[std::max(a, b)] = std::min(a, b);
  return true;
}

Twins find_twins(const TriangleMesh& mesh, const EdgeTable& edges) {
  Twins twins;
  twins.first.resize(mesh.triangles.size());
  std::iota(twins.first.begin(), twins.first.end(), 0u);
  twins.reversed.assign(mesh.triangles.size(), false);
  std::vector<EdgeUse> sorted;
  edges.for_each([&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses) {
    if (uses.size() < 2) return;
    // Facets with the same corners meet on each of their sides with the same corner across.
    sorted.assign(uses.begin(), uses.end());
    std::stable_sort(sorted.begin(), sorted.end(), [&](const EdgeUse& a, const EdgeUse& b) {
      return opposite(mesh, a.slot) < opposite(mesh, b.slot);
    });
    std::size_t head = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i) {
      if (opposite(mesh, sorted[i].slot) != opposite(mesh, sorted[head].slot)) {
        head = i;
        continue;
      }
      const std::uint32_t f = facet_of(sorted[i].slot);
      twins.first[f] = facet_of(sorted[head].slot);
      twins.reversed[f] = edge_begin(mesh, sorted[i].slot) != edge_begin(mesh, sorted[head].slot);
    }
  });
  return twins;
}

}  // namespace voidpath::mesh

#include "engine/slice/topology.h"

#include <algorithm>

namespace voidpath::slice {

namespace {

/// A half-edge as its lower vertex sees it.
struct Spoke {
  std::uint32_t far;  ///< the higher vertex
  HalfEdge half_edge;
  bool away;  ///< from the lower vertex to the higher
};

/// Beyond this many spokes a vertex's are sorted before they are paired.
constexpr std::ptrdiff_t kFewSpokes = 24;

void pair(const Spoke& a, const Spoke& b, std::vector<HalfEdge>& twins) {
  twins[a.half_edge] = b.half_edge;
  twins[b.half_edge] = a.half_edge;
}

void pair_spokes(Spoke* begin, Spoke* end, std::vector<HalfEdge>& twins) {
  const bool sorted = end - begin > kFewSpokes;
  if (sorted)
    std::sort(begin, end, [](const Spoke& a, const Spoke& b) {
      return a.far != b.far ? a.far < b.far : a.half_edge < b.half_edge;
    });
  for (Spoke* a = begin; a != end; ++a) {
    if (twins[a->half_edge] != kNoTwin) continue;
    for (Spoke* b = a + 1; b != end; ++b) {
      if (b->far != a->far) {
        if (sorted) break;
        continue;
      }
      if (b->away == a->away || twins[b->half_edge] != kNoTwin) continue;
      pair(*a, *b, twins);
      break;
    }
  }
}

}  // namespace

std::vector<HalfEdge> edge_twins(std::span<const mesh::Triangle> triangles, std::size_t vertex_count) {
  // Counting sort of all half-edges by their lower vertex.
  std::vector<std::uint32_t> first(vertex_count + 1, 0);
  for (const mesh::Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) ++first[std::min(t[k], t[(k + 1) % 3]) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) first[v + 1] += first[v];
  std::vector<Spoke> spokes(3 * triangles.size());
  std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[t][k];
      const std::uint32_t b = triangles[t][(k + 1) % 3];
      spokes[next[std::min(a, b)]++] = {std::max(a, b), static_cast<HalfEdge>(3 * t + k), a < b};
    }
  std::vector<HalfEdge> twins(spokes.size(), kNoTwin);
  for (std::size_t v = 0; v < vertex_count; ++v)
    pair_spokes(spokes.data() + first[v], spokes.data() + first[v + 1], twins);
  return twins;
}

}  // namespace voidpath::slice

#include "engine/orient/self_contact.h"

#include "engine/run/parallel_for.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace voidpath::orient {

namespace {

using Corners = std::array<Vec3, 3>;

/// Facets on one edge whose planes differ by more do not lie on one another, whatever the touch.
constexpr double kFoldedCosine = 0.999;

struct Box {
  Vec3 low = Vec3::Constant(1e300);
  Vec3 high = Vec3::Constant(-1e300);
  void add(const Vec3& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void add(const Box& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  bool meets(const Box& b) const {
    return (low.array() <= b.high.array()).all() && (b.low.array() <= high.array()).all();
  }
};

/// Heights of b's corners over a's plane, nil where they lie in it; false when b is all on one side, touching
/// at most.
bool straddles(const std::array<double, 3>& h) {
  const auto [low, high] = std::minmax({h[0], h[1], h[2]});
  return low < 0 && high > 0;
}

std::array<double, 3> heights_over(const Vec3& origin, const Vec3& normal, const Corners& b, double touch) {
  std::array<double, 3> h{};
  for (std::size_t k = 0; k < 3; ++k) {
    h[k] = normal.dot(b[k] - origin);
    if (std::abs(h[k]) <= touch) h[k] = 0;
  }
  return h;
}

/// Where the triangle crosses the plane its heights are over, as an interval along `line`.
std::pair<double, double> crossing(const Corners& t, const std::array<double, 3>& h, const Vec3& origin,
                                   const Vec3& line) {
  double low = 1e300;
  double high = -1e300;
  auto add = [&](double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t m = (k + 1) % 3;
    const double a = line.dot(t[k] - origin);
    const double b = line.dot(t[m] - origin);
    if (h[k] == 0) add(a);
    if ((h[k] < 0 && h[m] > 0) || (h[k] > 0 && h[m] < 0)) add(a + (b - a) * h[k] / (h[k] - h[m]));
  }
  return {low, high};
}

/// Triangles in one plane overlap unless an edge of one has the other wholly beyond it.
bool overlap_in_plane(const Corners& a, const Corners& b, const Vec3& normal, double touch) {
  auto separated = [&](const Corners& p, const Corners& q, const Vec3& n) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 edge = p[(k + 1) % 3] - p[k];
      const double length = edge.norm();
      if (length <= touch) continue;
      const Vec3 outward = edge.cross(n) / length;
      double nearest = 1e300;
      for (const Vec3& c : q) nearest = std::min(nearest, outward.dot(c - p[k]));
      if (nearest >= -touch) return true;
    }
    return false;
  };
  const Vec3 nb = (b[1] - b[0]).cross(b[2] - b[0]);
  return !separated(a, b, normal) && !separated(b, a, nb.dot(normal) > 0 ? normal : Vec3(-normal));
}

bool contact(const Corners& a, const Vec3& na, const Corners& b, const Vec3& nb, double touch) {
  const std::array<double, 3> hb = heights_over(a[0], na, b, touch);
  const std::array<double, 3> ha = heights_over(b[0], nb, a, touch);
  const bool flat = (hb[0] == 0 && hb[1] == 0 && hb[2] == 0) || (ha[0] == 0 && ha[1] == 0 && ha[2] == 0);
  if (flat) return overlap_in_plane(a, b, na, touch);
  if (!straddles(hb) || !straddles(ha)) return false;
  const Vec3 line = na.cross(nb);
  const double length = line.norm();
  if (length == 0) return false;
  const auto [a0, a1] = crossing(a, ha, a[0], line / length);
  const auto [b0, b1] = crossing(b, hb, a[0], line / length);
  return std::min(a1, b1) - std::max(a0, b0) > touch;
}

/// Boxes around facets, halved along the longest side; leaves hold up to kLeaf facets.
class BoxTree {
 public:
  static constexpr std::size_t kLeaf = 4;

  BoxTree(const Solid& s, double touch) : facets_(s.triangles.size()), boxes_(s.triangles.size()) {
    std::iota(facets_.begin(), facets_.end(), Index{0});
    std::vector<Vec3> middles(s.triangles.size());
    for (std::size_t t = 0; t < boxes_.size(); ++t) {
      for (const Index v : s.triangles[t]) boxes_[t].add(s.vertices[v]);
      middles[t] = boxes_[t].low + boxes_[t].high;
      boxes_[t].low.array() -= 0.5 * touch;
      boxes_[t].high.array() += 0.5 * touch;
    }
    nodes_.reserve(facets_.size());
    build(0, facets_.size(), middles);
  }

  /// Calls visit(facet) for every facet whose box, widened by half the touch on every side, meets that of
  /// `facet`.
  template <class Visit>
  void each_near(Index facet, const Visit& visit) const {
    const Box& box = boxes_[facet];
    std::array<Index, 64> stack;  // halving keeps the depth below 32
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
      const Node& node = nodes_[stack[--depth]];
      if (!node.box.meets(box)) continue;
      if (node.right == 0) {
        for (std::size_t i = node.begin; i < node.end; ++i)
          if (boxes_[facets_[i]].meets(box)) visit(facets_[i]);
      } else {
        stack[depth++] = node.right;
        stack[depth++] = static_cast<Index>(&node - nodes_.data()) + 1;
      }
    }
  }

 private:
  struct Node {
    Box box;
    std::size_t begin, end;
    Index right;  ///< 0 for a leaf; the left child follows its parent
  };

  Index build(std::size_t begin, std::size_t end, const std::vector<Vec3>& middles) {
    const auto at = static_cast<Index>(nodes_.size());
    nodes_.push_back({{}, begin, end, 0});
    Box box;
    Box spread;
    for (std::size_t i = begin; i < end; ++i) {
      box.add(boxes_[facets_[i]]);
      spread.add(middles[facets_[i]]);
    }
    nodes_[at].box = box;
    if (end - begin <= kLeaf) return at;
    Vec3::Index axis = 0;
    (spread.high - spread.low).maxCoeff(&axis);
    const std::size_t half = begin + (end - begin) / 2;
    const auto first = facets_.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(half),
                     first + static_cast<std::ptrdiff_t>(end), [&](Index a, Index b) {
                       return middles[a][axis] != middles[b][axis] ? middles[a][axis] < middles[b][axis]
                                                                   : a < b;
                     });
    build(begin, half, middles);
    nodes_[at].right = build(half, end, middles);
    return at;
  }

  std::vector<Index> facets_;
  std::vector<Box> boxes_;
  std::vector<Node> nodes_;
};

}  // namespace

std::vector<std::pair<Index, Index>> find_self_contacts(const Solid& s, const run::Context& ctx) {
  if (s.triangles.empty()) return {};
  const double touch = touch_mm(s);
  const BoxTree tree(s, touch);
  constexpr std::size_t kChunk = 1024;
  const std::size_t chunks = (s.triangles.size() + kChunk - 1) / kChunk;
  std::vector<std::vector<std::pair<Index, Index>>> found(chunks);
  auto corners = [&](Index t) {
    const auto& [a, b, c] = s.triangles[t];
    return Corners{s.vertices[a], s.vertices[b], s.vertices[c]};
  };
  // Neighbours meet in their edge, unless one is folded onto the other: bodies that lie on one another with
  // the same corners.
  auto may_meet = [&](Index t, Index u) {
    int shared = 0;
    for (const Index a : s.triangles[t])
      for (const Index b : s.triangles[u]) shared += a == b ? 1 : 0;
    return shared < 2 || std::abs(s.triangle_normals[t].dot(s.triangle_normals[u])) > kFoldedCosine;
  };
  run::parallel_for(ctx, chunks, [&](std::size_t chunk) {
    const std::size_t end = std::min((chunk + 1) * kChunk, s.triangles.size());
    for (std::size_t i = chunk * kChunk; i < end; ++i) {
      const auto t = static_cast<Index>(i);
      const Vec3& n = s.triangle_normals[t];
      if (n.isZero(0)) continue;
      const Corners a = corners(t);
      const std::size_t before = found[chunk].size();
      tree.each_near(t, [&](Index u) {
        if (u <= t || s.triangle_normals[u].isZero(0) || !may_meet(t, u)) return;
        if (contact(a, n, corners(u), s.triangle_normals[u], touch)) found[chunk].emplace_back(t, u);
      });
      std::sort(found[chunk].begin() + static_cast<std::ptrdiff_t>(before), found[chunk].end());
    }
  });
  std::vector<std::pair<Index, Index>> out;
  for (const auto& part : found) out.insert(out.end(), part.begin(), part.end());
  return out;
}

}  // namespace voidpath::orient

#include "engine/orient/self_contact.h"

#include "engine/orient/lanes.h"
#include "engine/run/parallel_for.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace voidpath::orient {

namespace {

using Corners = std::array<Vec3, 3>;

/// Facets on one edge whose planes differ by more do not lie on one another, whatever the touch.
constexpr double kFoldedCosine = 0.999;

/// Share of the part's size by which boxes are wider than what they hold, for single precision.
constexpr double kBoxNoise = 1e-6;

struct Box {
  Lanes low = Lanes{} + std::numeric_limits<float>::infinity();
  Lanes high = Lanes{} - std::numeric_limits<float>::infinity();
  void add(const Box& b) {
    low = lower_of(low, b.low);
    high = higher_of(high, b.high);
  }
  bool meets(const Box& b) const { return !any((low > b.high) | (b.low > high)); }
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

/// Boxes around facets, widened by half the touch, and around ever more of them as they follow one another:
/// tight where the solid's facets lie in memory as in space.
class BoxTree {
 public:
  BoxTree(const Solid& s, double touch) : count_(s.triangles.size()) {
    while (leaves_ * kLeaf < count_) leaves_ *= 2;
    facets_.resize(count_);
    nodes_.resize(2 * leaves_);
    const auto wider = static_cast<float>(0.5 * touch + kBoxNoise * s.radius_mm);
    for (std::size_t t = 0; t < count_; ++t) {
      for (const Index v : s.triangles[t]) {
        const Eigen::Vector3f p = s.vertices[v].cast<float>();
        const Lanes at{p.x(), p.y(), p.z(), 0};
        facets_[t].add({at - wider, at + wider});
      }
      nodes_[leaves_ + t / kLeaf].add(facets_[t]);
    }
    for (std::size_t i = leaves_; i-- > 1;) {
      nodes_[i] = nodes_[2 * i];
      nodes_[i].add(nodes_[2 * i + 1]);
    }
  }

  std::size_t leaves() const { return (count_ + kLeaf - 1) / kLeaf; }

  /// Calls visit(t, u) for every facet t of that leaf and u > t whose boxes meet.
  template <class Visit>
  void each_pair(std::size_t leaf, const Visit& visit) const {
    const Box& box = nodes_[leaves_ + leaf];
    std::array<std::size_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 1;
    while (depth > 0) {
      const std::size_t node = stack[--depth];
      if (!nodes_[node].meets(box)) continue;
      if (node >= leaves_) {
        pair_up(leaf, node - leaves_, visit);
        continue;
      }
      stack[depth++] = 2 * node + 1;
      if (last_leaf_below(2 * node) >= leaf) stack[depth++] = 2 * node;
    }
  }

 private:
  static constexpr std::size_t kLeaf = 4;

  std::size_t last_leaf_below(std::size_t node) const {
    std::size_t last = node + 1;
    while (last <= leaves_) last *= 2;
    return last - 1 - leaves_;
  }

  template <class Visit>
  void pair_up(std::size_t a, std::size_t b, const Visit& visit) const {
    const std::size_t end_a = std::min((a + 1) * kLeaf, count_);
    const std::size_t end_b = std::min((b + 1) * kLeaf, count_);
    for (std::size_t t = a * kLeaf; t < end_a; ++t)
      for (std::size_t u = std::max(t + 1, b * kLeaf); u < end_b; ++u)
        if (facets_[t].meets(facets_[u])) visit(static_cast<Index>(t), static_cast<Index>(u));
  }

  std::size_t count_;
  std::size_t leaves_ = 1;  ///< a power of two
  std::vector<Box> facets_;
  std::vector<Box> nodes_;  ///< heap order from 1; the leaves from leaves_
};

}  // namespace

std::vector<std::pair<Index, Index>> find_self_contacts(const Solid& s, const run::Context& ctx) {
  if (s.triangles.empty()) return {};
  const double touch = touch_mm(s);
  const BoxTree tree(s, touch);
  constexpr std::size_t kChunk = 256;  // leaves
  const std::size_t chunks = (tree.leaves() + kChunk - 1) / kChunk;
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
    const std::size_t end = std::min((chunk + 1) * kChunk, tree.leaves());
    for (std::size_t leaf = chunk * kChunk; leaf < end; ++leaf)
      tree.each_pair(leaf, [&](Index t, Index u) {
        const Vec3& nt = s.triangle_normals[t];
        const Vec3& nu = s.triangle_normals[u];
        if (nt.isZero(0) || nu.isZero(0) || !may_meet(t, u)) return;
        if (contact(corners(t), nt, corners(u), nu, touch)) found[chunk].emplace_back(t, u);
      });
    std::sort(found[chunk].begin(), found[chunk].end());
  });
  std::vector<std::pair<Index, Index>> out;
  for (const auto& part : found) out.insert(out.end(), part.begin(), part.end());
  return out;
}

}  // namespace voidpath::orient

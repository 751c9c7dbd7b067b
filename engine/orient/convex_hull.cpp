#include "engine/orient/convex_hull.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace voidpath::orient {

namespace {

using geom::Vec3;
using Index = std::uint32_t;

/// Share of the cloud's size below which a point counts as lying in a facet's plane: above the noise of
/// single-precision coordinates, which would else make facets of points in line, with planes that mean
/// nothing.
constexpr double kOnPlane = 1e-6;

class Quickhull {
 public:
  explicit Quickhull(const std::vector<Vec3>& points) : points_(points) {}

  std::vector<mesh::Triangle> run() {
    if (points_.size() < 4 || !start()) return {};
    for (std::size_t next = 0; next < facets_.size(); ++next) {
      // Facets made later stand later in the list, so one pass meets them all.
      while (facets_[next].alive && !facets_[next].outside.empty()) add_apex(static_cast<Index>(next));
    }
    std::vector<mesh::Triangle> out;
    for (const Facet& f : facets_)
      if (f.alive) out.push_back(f.v);
    return out;
  }

 private:
  struct Facet {
    mesh::Triangle v{};
    std::array<Index, 3> beside{};  ///< across the edge from corner k to k + 1
    Vec3 normal = Vec3::Zero();
    double offset = 0;
    std::vector<Index> outside;  ///< points this facet sees, farthest last
    double farthest = 0;
    bool alive = true;
    bool seen = false;
  };

  double above(const Facet& f, Index p) const { return f.normal.dot(points_[p]) - f.offset; }

  Index make_facet(Index a, Index b, Index c) {
    Facet f;
    f.v = {a, b, c};
    const Vec3 n = (points_[b] - points_[a]).cross(points_[c] - points_[a]);
    const double length = n.norm();
    f.normal = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    f.offset = f.normal.dot(points_[a]);
    facets_.push_back(std::move(f));
    return static_cast<Index>(facets_.size() - 1);
  }

  void give(Index facet, Index point) {
    Facet& f = facets_[facet];
    const double h = above(f, point);
    f.outside.push_back(point);
    if (h > f.farthest || f.outside.size() == 1) {
      f.farthest = h;
    } else {
      std::swap(f.outside[f.outside.size() - 1], f.outside[f.outside.size() - 2]);
    }
  }

  /// A tetrahedron of far apart points; false when the cloud is flat.
  bool start() {
    Vec3 lo = points_[0];
    Vec3 hi = points_[0];
    for (const Vec3& p : points_) {
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
    tolerance_ = kOnPlane * (hi - lo).norm();
    auto farthest = [&](auto&& measure) {
      Index best = 0;
      double most = -1;
      for (Index i = 0; i < points_.size(); ++i)
        if (const double m = measure(points_[i]); m > most) most = m, best = i;
      return std::pair(best, most);
    };
    const auto [a, da] = farthest([&](const Vec3& p) { return (p - lo).norm(); });
    const Vec3 pa = points_[a];
    const auto [b, db] = farthest([&](const Vec3& p) { return (p - pa).norm(); });
    if (db <= tolerance_) return false;
    const Vec3 along = (points_[b] - pa).normalized();
    const auto [c, dc] = farthest([&](const Vec3& p) { return (p - pa).cross(along).norm(); });
    if (dc <= tolerance_) return false;
    const Vec3 normal = along.cross(points_[c] - pa).normalized();
    const auto [d, dd] = farthest([&](const Vec3& p) { return std::abs(normal.dot(p - pa)); });
    if (dd <= tolerance_) return false;
    std::array<Index, 4> t{a, b, c, d};
    if (normal.dot(points_[d] - pa) > 0) std::swap(t[1], t[2]);
    // Now d is below a b c. Facets and who is beside whom, edge by edge.
    make_facet(t[0], t[1], t[2]);
    make_facet(t[0], t[3], t[1]);
    make_facet(t[1], t[3], t[2]);
    make_facet(t[2], t[3], t[0]);
    facets_[0].beside = {1, 2, 3};
    facets_[1].beside = {3, 2, 0};
    facets_[2].beside = {1, 3, 0};
    facets_[3].beside = {2, 1, 0};
    for (Index i = 0; i < points_.size(); ++i) {
      for (Index f = 0; f < 4; ++f)
        if (above(facets_[f], i) > tolerance_) {
          give(f, i);
          break;
        }
    }
    return true;
  }

  struct HorizonEdge {
    Index a, b;    ///< as it runs in the facet that goes
    Index beyond;  ///< facet that stays
  };

  /// The edge loop around what the apex sees, in order around it.
  void find_horizon(Index from, Index apex) {
    horizon_.clear();
    seen_.clear();
    // Depth first, edges in turn: crossing into a seen facet continues after the edge crossed, which leaves
    // the horizon in cyclic order.
    struct Step {
      Index facet;
      int edge;
      int left;
    };
    std::vector<Step> stack{{from, 0, 3}};
    facets_[from].seen = true;
    seen_.push_back(from);
    while (!stack.empty()) {
      Step& s = stack.back();
      if (s.left == 0) {
        stack.pop_back();
        continue;
      }
      const auto k = static_cast<std::size_t>(s.edge);
      const Index at = s.facet;
      s.edge = (s.edge + 1) % 3;
      --s.left;
      const Index next = facets_[at].beside[k];
      Facet& other = facets_[next];
      if (other.seen) continue;
      if (above(other, apex) > tolerance_) {
        other.seen = true;
        seen_.push_back(next);
        const int entry = edge_towards(next, facets_[at].v[(k + 1) % 3]);
        stack.push_back({next, (entry + 1) % 3, 2});
      } else {
        horizon_.push_back({facets_[at].v[k], facets_[at].v[(k + 1) % 3], next});
      }
    }
  }

  bool is_loop() const {
    for (std::size_t i = 0; i < horizon_.size(); ++i)
      if (horizon_[i].b != horizon_[(i + 1) % horizon_.size()].a) return false;
    return horizon_.size() >= 3;
  }

  /// The edge of `facet` that starts at vertex `from`.
  int edge_towards(Index facet, Index from) const {
    for (int k = 0; k < 3; ++k)
      if (facets_[facet].v[static_cast<std::size_t>(k)] == from) return k;
    return 0;
  }

  void add_apex(Index facet) {
    const Index apex = facets_[facet].outside.back();
    facets_[facet].outside.pop_back();
    find_horizon(facet, apex);
    if (!is_loop()) {  // rounding tore the seen part; the apex is within noise of the hull
      for (const Index f : seen_) facets_[f].seen = false;
      return;
    }
    const auto first = static_cast<Index>(facets_.size());
    const auto count = static_cast<Index>(horizon_.size());
    for (Index i = 0; i < count; ++i) {
      const HorizonEdge e = horizon_[i];
      const Index f = make_facet(e.a, e.b, apex);
      facets_[f].beside = {e.beyond, first + (i + 1) % count, first + (i + count - 1) % count};
      facets_[e.beyond].beside[static_cast<std::size_t>(edge_towards(e.beyond, e.b))] = f;
    }
    for (const Index gone : seen_) {
      facets_[gone].alive = false;
      const std::vector<Index> orphans = std::exchange(facets_[gone].outside, {});
      for (const Index p : orphans) {
        if (p == apex) continue;
        for (Index f = first; f < first + count; ++f)
          if (above(facets_[f], p) > tolerance_) {
            give(f, p);
            break;
          }
      }
    }
  }

  const std::vector<Vec3>& points_;
  double tolerance_ = 0;
  std::vector<Facet> facets_;
  std::vector<HorizonEdge> horizon_;
  std::vector<Index> seen_;
};

}  // namespace

std::vector<mesh::Triangle> convex_hull(const std::vector<Vec3>& points) { return Quickhull(points).run(); }

}  // namespace voidpath::orient

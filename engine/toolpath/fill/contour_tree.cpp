#include "engine/toolpath/fill/contour_tree.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;

/// Contours this many spacings apart or nearer lie side by side.
constexpr double kBeside = 1.35;
/// Others are joined over up to this many when nothing is nearer: corners pointed inwards leave such gaps.
constexpr double kNear = 2.2;
/// Contours are compared in points this many spacings apart.
constexpr double kProbeSpacings = 2.0;
/// Detail of contours below this is dropped, mm: they would only hand it on inwards.
constexpr double kToleranceMm = 0.01;
/// Neighbouring contours may come this close, as a share of their spacing; nearer, the inner one is left out.
constexpr double kMinSpacingShare = 0.8;
/// Contours shorter than this many spacings are blobs: what they would cover is filled like a gap.
constexpr double kMinRingSpacings = 5.0;
/// Slivers below this width, as a share of a spacing, and below this area, mm², are left open.
constexpr double kMinGapShare = 0.2;
constexpr double kMinGapMm2 = 0.02;

/// Two contours side by side over `shared` probes.
struct Edge {
  std::uint32_t a, b;
  std::size_t shared;
};

class Forest {
 public:
  explicit Forest(const BeadSize& bead) : spacing_(bead.spacing_mm() * geom::kNmPerMm) {}

  ContourForest run(const geom::Region& domain) {
    descend({domain}, geom::simplify({domain}, from_mm(kToleranceMm)), {}, 0);
    join();
    return std::move(out_);
  }

 private:
  /// Adds the contours of `regions`, whose centre lines they are, and all within. `area` is what was to be
  /// covered by them; `outside` the contours one level further out.
  void descend(const geom::Regions& area, const geom::Regions& regions,
               const std::vector<std::uint32_t>& outside, std::uint32_t level) {
    if (level > 0) collect_gaps(area, geom::offset(regions, std::llround(0.5 * spacing_)));
    for (const geom::Region& region : regions) {
      std::vector<std::uint32_t> own;
      for (geom::Ring& ring : geom::rings_of({region})) {
        own.push_back(static_cast<std::uint32_t>(out_.contours.size()));
        out_.contours.push_back({std::move(ring), level, {}});
      }
      for (std::size_t i = 0; i < own.size(); ++i) {
        for (const std::uint32_t o : outside) add_edge(own[i], o);
        for (std::size_t j = 0; j < i; ++j) add_edge(own[i], own[j]);
      }
      const geom::Regions rest = geom::offset({region}, -std::llround(0.5 * spacing_));
      if (rest.empty()) continue;
      const auto back = static_cast<geom::Coord>(0.5 * kMinSpacingShare * spacing_);
      geom::Regions next = geom::offset(geom::offset(rest, -std::llround(0.5 * spacing_) - back), back);
      std::erase_if(next, [&](const geom::Region& r) {
        return geom::perimeter(r.outer) < kMinRingSpacings * spacing_;
      });
      descend(rest, geom::simplify(next, from_mm(kToleranceMm)), own, level + 1);
    }
  }

  void collect_gaps(const geom::Regions& area, const geom::Regions& covered) {
    geom::Regions left = quick_subtract(area, covered);
    if (left.empty()) return;
    left = geom::open(left, std::llround(0.5 * kMinGapShare * spacing_));
    append(out_.gaps, geom::remove_small(left, kMinGapMm2 * geom::kNmPerMm * geom::kNmPerMm));
  }

  /// Probes along the shorter contour that find the other beside them.
  void add_edge(std::uint32_t a, std::uint32_t b) {
    const geom::Ring *p = &out_.contours[a].ring, *q = &out_.contours[b].ring;
    const auto reach = static_cast<geom::Coord>(kNear * spacing_);
    const auto box_p = geom::bounds(*p), box_q = geom::bounds(*q);
    if (!box_p || !box_q || !overlap(grown(*box_p, reach), *box_q)) return;
    if (geom::perimeter(*p) > geom::perimeter(*q)) std::swap(p, q);
    std::size_t shared = 0;
    double nearest = kNear * spacing_;
    for (std::size_t k = 0; k < p->size(); ++k) {
      const Point &from = (*p)[k], &to = (*p)[(k + 1) % p->size()];
      const auto parts = static_cast<geom::Coord>(geom::distance(from, to) / (kProbeSpacings * spacing_)) + 1;
      for (geom::Coord j = 0; j < parts; ++j) {
        const Point at{from.x + (to.x - from.x) * j / parts, from.y + (to.y - from.y) * j / parts};
        const double d = nearest_on_ring(*q, at).distance;
        nearest = std::min(nearest, d);
        if (d <= kBeside * spacing_) ++shared;
      }
    }
    if (nearest < kNear * spacing_) edges_.push_back({a, b, shared});
  }

  /// A spanning forest of the longest neighbourhoods (Kruskal), rooted where the level is least.
  void join() {
    const std::size_t n = out_.contours.size();
    std::stable_sort(edges_.begin(), edges_.end(),
                     [](const Edge& x, const Edge& y) { return x.shared > y.shared; });
    std::vector<std::uint32_t> group(n);
    for (std::uint32_t i = 0; i < n; ++i) group[i] = i;
    auto find = [&](std::uint32_t i) {
      while (group[i] != i) i = group[i] = group[group[i]];
      return i;
    };
    std::vector<std::vector<std::uint32_t>> beside(n);
    for (const Edge& e : edges_) {
      const std::uint32_t a = find(e.a), b = find(e.b);
      if (a == b) continue;
      group[std::max(a, b)] = std::min(a, b);
      beside[e.a].push_back(e.b);
      beside[e.b].push_back(e.a);
    }
    // Contours are numbered from the border inwards: the first of each tree is its root.
    std::vector<char> seen(n, 0);
    for (std::uint32_t r = 0; r < n; ++r) {
      if (seen[r]) continue;
      out_.roots.push_back(r);
      seen[r] = 1;
      std::vector<std::uint32_t> open{r};
      while (!open.empty()) {
        const std::uint32_t c = open.back();
        open.pop_back();
        for (const std::uint32_t d : beside[c]) {
          if (seen[d]) continue;
          seen[d] = 1;
          out_.contours[c].children.push_back(d);
          open.push_back(d);
        }
      }
    }
  }

  double spacing_;  ///< nm
  ContourForest out_;
  std::vector<Edge> edges_;
};

}  // namespace

OnRing nearest_on_ring(const geom::Ring& ring, const Point& p) {
  OnRing best;
  best.distance = std::numeric_limits<double>::max();
  double along = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Point &a = ring[k], &b = ring[(k + 1) % ring.size()];
    const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
    const double len2 = dx * dx + dy * dy;
    const double share =
        len2 > 0 ? (static_cast<double>(p.x - a.x) * dx + static_cast<double>(p.y - a.y) * dy) / len2 : 0;
    const double t = std::clamp(share, 0.0, 1.0);
    const double ex = static_cast<double>(a.x - p.x) + t * dx, ey = static_cast<double>(a.y - p.y) + t * dy;
    const double d2 = ex * ex + ey * ey;
    if (d2 < best.distance) {
      best.distance = d2;
      best.at = {a.x + std::llround(t * dx), a.y + std::llround(t * dy)};
      best.along = along + t * std::sqrt(len2);
    }
    along += std::sqrt(len2);
  }
  best.distance = std::sqrt(best.distance);
  return best;
}

ContourForest contour_forest(const geom::Region& domain, const BeadSize& bead) {
  return Forest(bead).run(domain);
}

}  // namespace voidpath::toolpath

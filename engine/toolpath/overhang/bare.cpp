#include "engine/toolpath/overhang/bare.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/way.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

/// What is left and thinner than this, mm, or smaller than this, mm², is rounding of corners.
constexpr double kLeastBareMm = 0.1;
constexpr double kLeastBareMm2 = 0.03;
/// A corner that turns by more than this cosine tells may be a tip's...
constexpr double kCornerCosine = 0.85;
/// ...whose sides are looked at so far from it, mm...
constexpr double kSideMm = 0.25;
/// ...and whose angle between them is no more than this, degrees: a wall reaches nearly into others.
constexpr double kTipDeg = 75;

geom::Regions covered_by_gap_lines(const std::vector<Path>& paths) {
  geom::Rings quads;
  for (const Path& path : paths) {
    if (path.role != Role::gap_fill || path.points.empty()) continue;
    geom::Polyline line = path.points;
    if (path.closed) line.push_back(line.front());
    add_beads(quads, line, path.width_mm * geom::kNmPerMm);
  }
  return geom::unite(quads);
}

/// From a ring's i-th corner to where its border is so far on, or back.
Way side(const geom::Ring& ring, std::size_t i, bool back) {
  const std::size_t n = ring.size();
  double left = kSideMm * geom::kNmPerMm;
  geom::Point at = ring[i];
  std::size_t k = i;
  for (std::size_t steps = 1; steps < n && left > 0; ++steps) {
    k = back ? (k + n - 1) % n : (k + 1) % n;
    const double step = geom::distance(at, ring[k]);
    const Way w = way(at, ring[k]);
    const double by = std::min(left, step);
    at = {at.x + std::llround(by * w.x), at.y + std::llround(by * w.y)};
    left -= step;
    if (left > 0) at = ring[k];
  }
  return way(ring[i], at);
}

/// Of acute corners, as far as a round bead along the border stays away from them.
geom::Regions corner_tips(const geom::Regions& outline, double width_mm) {
  geom::Rings tips;
  for (const geom::Ring& ring : geom::rings_of(outline))
    for (std::size_t i = 0, n = ring.size(); i < n; ++i) {
      const geom::Point& p = ring[i];
      const Way in = way(ring[(i + n - 1) % n], p), out = way(p, ring[(i + 1) % n]);
      if (in.x * out.x + in.y * out.y > kCornerCosine || in.x * out.y - in.y * out.x <= 0) continue;
      const Way ahead = side(ring, i, false), behind = side(ring, i, true);
      if (ahead.x * behind.y - ahead.y * behind.x <= 0) continue;  // wider than straight
      const double angle = std::acos(std::clamp(ahead.x * behind.x + ahead.y * behind.y, -1.0, 1.0));
      if (angle > kTipDeg * std::numbers::pi / 180 || angle <= 0) continue;
      const double height = 0.5 * width_mm * (1 / std::sin(0.5 * angle) - 1);
      const double length = height / std::cos(0.5 * angle) * geom::kNmPerMm;
      const auto at = [&](const Way& w) {
        return geom::Point{p.x + std::llround(length * w.x), p.y + std::llround(length * w.y)};
      };
      tips.push_back({p, at(ahead), at(behind)});
    }
  return tips.empty() ? geom::Regions{} : geom::unite(tips);
}

}  // namespace

geom::Regions bare_parts(const LayerWalls& walls, const std::vector<Path>& paths,
                         const geom::Regions& outline) {
  geom::Regions narrow;
  for (const Perimeters& island : walls.islands) {
    append(narrow, geom::Regions(island.gaps));
    append(narrow, geom::Regions(island.thin));
  }
  geom::Regions tips = corner_tips(outline, walls.bead.width_mm);
  if (narrow.empty() && tips.empty()) return narrow;
  const geom::Regions covered = covered_by_gap_lines(paths);
  const geom::Coord least = geom::from_mm(0.5 * kLeastBareMm);
  geom::Regions out = geom::remove_small(geom::open(quick_subtract(narrow, covered), least),
                                         kLeastBareMm2 * geom::kNmPerMm * geom::kNmPerMm);
  tips = geom::open(quick_subtract(tips, covered), least);
  return tips.empty() ? out : quick_unite(out, tips);
}

}  // namespace voidpath::toolpath

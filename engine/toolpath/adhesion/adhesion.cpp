#include "engine/toolpath/adhesion/adhesion.h"

#include "engine/geom/polygon_ops.h"

#include <algorithm>
#include <cmath>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;

/// Loops around the part may be this much plainer than it, mm: they only have to be there, and short segments
/// would slow the printer down.
constexpr double kLoopToleranceMm = 0.02;

geom::Regions plain(const geom::Regions& loops, const SliceSettings& settings) {
  return geom::simplify(loops, from_mm(std::max(settings.resolution_mm, kLoopToleranceMm)));
}

double turn(const Point& a, const Point& b, const Point& c) {
  return static_cast<double>(b.x - a.x) * static_cast<double>(c.y - a.y) -
         static_cast<double>(b.y - a.y) * static_cast<double>(c.x - a.x);
}

}  // namespace

geom::Ring convex_hull(std::vector<Point> points) {
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  geom::Ring hull(2 * points.size());
  std::size_t n = 0;
  auto add = [&](const Point& p, std::size_t least) {
    while (n >= least && turn(hull[n - 2], hull[n - 1], p) <= 0) --n;
    hull[n++] = p;
  };
  for (const Point& p : points) add(p, 2);
  const std::size_t lower = n + 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.resize(n - 1);
  return hull;
}

geom::Rings skirt_loops(const geom::Regions& around, const SliceSettings& settings, const BeadSize& bead) {
  geom::Rings out;
  if (settings.skirt_loops <= 0 || around.empty()) return out;
  std::vector<Point> points;
  for (const auto& r : around) points.insert(points.end(), r.outer.begin(), r.outer.end());
  geom::Ring hull = convex_hull(std::move(points));
  if (hull.size() < 3) return out;
  const geom::Regions base{{std::move(hull), {}}};
  for (int k = settings.skirt_loops; k-- > 0;) {
    const double by = settings.skirt_gap_mm + bead.spacing_mm() * (k + 0.5);
    for (auto& region : plain(geom::offset(base, from_mm(by), geom::Join::round), settings))
      out.push_back(std::move(region.outer));
  }
  return out;
}

}  // namespace voidpath::toolpath

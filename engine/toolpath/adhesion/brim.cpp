#include "engine/toolpath/adhesion/brim.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Regions;
using geom::Ring;

/// A corner's angle is measured this far to both sides of it, mm: small chamfers and fillets are corners too.
constexpr double kCornerReachMm = 1.5;
/// Contours are simplified to this before corners are looked for, mm.
constexpr double kCornerToleranceMm = 0.05;
/// Lines of one ear whose ends are this near, in spacings, are printed in one go.
constexpr double kLinkSpacings = 3.0;
constexpr int kEarSides = 48;
/// Loops may be this much plainer than the part, mm: short segments would slow the printer down.
constexpr double kLoopToleranceMm = 0.02;

/// The point this far along the ring from vertex i, forwards (step 1) or backwards (step n - 1).
Point walk(const Ring& ring, std::size_t i, std::size_t step, double way) {
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Point& a = ring[i];
    i = (i + step) % ring.size();
    const Point& b = ring[i];
    const double d = geom::distance(a, b);
    if (d >= way) {
      const double t = way / d;
      return {a.x + std::llround(t * static_cast<double>(b.x - a.x)),
              a.y + std::llround(t * static_cast<double>(b.y - a.y))};
    }
    way -= d;
  }
  return ring[i];
}

/// Inside the contours, holes filled.
Regions filled(const Regions& regions) {
  geom::Rings outers;
  for (const auto& r : regions) outers.push_back(r.outer);
  Regions out = geom::unite(outers);
  for (auto& r : out) r.holes.clear();
  return out;
}

/// Joins the pieces of neighbouring loops to zigzags.
geom::Polylines zigzags(const std::vector<geom::Polylines>& by_loop, double link) {
  geom::Polylines out;
  std::vector<bool> growing;  // its end lies on the loop before
  for (const auto& pieces : by_loop) {
    std::vector<bool> next(out.size(), false);
    for (const auto& piece : pieces) {
      std::size_t best = out.size();
      double least = link;
      bool reversed = false;
      for (std::size_t k = 0; k < growing.size(); ++k) {
        if (!growing[k] || next[k]) continue;
        const double ahead = geom::distance(out[k].back(), piece.front());
        const double behind = geom::distance(out[k].back(), piece.back());
        if (std::min(ahead, behind) > least) continue;
        least = std::min(ahead, behind);
        best = k;
        reversed = behind < ahead;
      }
      if (best == out.size()) {
        out.push_back(piece);
        next.push_back(true);
        continue;
      }
      if (reversed)
        out[best].insert(out[best].end(), piece.rbegin(), piece.rend());
      else
        out[best].insert(out[best].end(), piece.begin(), piece.end());
      next[best] = true;
    }
    growing = std::move(next);
  }
  return out;
}

/// What of the loops lies in the ears.
Brim cut_ears(const std::vector<geom::Rings>& by_loop, const Regions& ears, double link) {
  Brim out;
  std::vector<geom::Polylines> pieces;
  for (const auto& loops : by_loop) {
    pieces.emplace_back();
    for (const Ring& loop : loops) {
      geom::Polyline line = loop;
      line.push_back(loop.front());
      geom::Polylines inside = geom::clip_inside({line}, ears);
      // Where the loop begins inside an ear, that ear's line comes in two.
      if (inside.size() > 1 && inside.front().front() == loop.front() &&
          inside.back().back() == loop.front()) {
        inside.back().insert(inside.back().end(), inside.front().begin() + 1, inside.front().end());
        inside.erase(inside.begin());
      }
      if (inside.size() == 1 && inside.front().size() == line.size() &&
          inside.front().front() == inside.front().back())
        out.loops.push_back(loop);
      else
        pieces.back().insert(pieces.back().end(), inside.begin(), inside.end());
    }
  }
  out.ears = zigzags(pieces, link);
  return out;
}

}  // namespace

std::vector<Point> sharp_corners(const Regions& part, double max_angle_deg) {
  std::vector<Point> out;
  const double most = std::cos(max_angle_deg * std::numbers::pi / 180.0);
  const double reach = kCornerReachMm * geom::kNmPerMm;
  for (const auto& region : geom::simplify(part, from_mm(kCornerToleranceMm))) {
    const Ring& ring = region.outer;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point before = walk(ring, i, ring.size() - 1, reach);
      const Point after = walk(ring, i, 1, reach);
      const double ax = static_cast<double>(before.x - ring[i].x);
      const double ay = static_cast<double>(before.y - ring[i].y);
      const double bx = static_cast<double>(after.x - ring[i].x);
      const double by = static_cast<double>(after.y - ring[i].y);
      const double size = std::hypot(ax, ay) * std::hypot(bx, by);
      const bool convex = ax * by - ay * bx < 0;
      if (size > 0 && convex && ax * bx + ay * by >= most * size) out.push_back(ring[i]);
    }
  }
  return out;
}

Brim make_brim(const Regions& footprint, const Regions& part, const SliceSettings& settings,
               const BeadSize& bead) {
  Brim out;
  if (settings.brim_width_mm <= 0 || footprint.empty()) return out;
  const double spacing = bead.spacing_mm();
  const auto count = std::max(1, static_cast<int>(std::floor(settings.brim_width_mm / spacing)));
  const bool wants_inner = settings.brim_type == BrimType::inner || settings.brim_type == BrimType::both;
  const bool wants_outer = settings.brim_type != BrimType::inner;
  const geom::AreaGrid within(filled(footprint));
  std::vector<geom::Rings> by_loop;
  for (int k = count; k-- > 0;) {
    by_loop.emplace_back();
    const double by = settings.brim_gap_mm + spacing * (k + 0.5);
    const Regions around = geom::simplify(geom::offset(footprint, from_mm(by), geom::Join::round),
                                          from_mm(std::max(settings.resolution_mm, kLoopToleranceMm)));
    for (auto& ring : geom::rings_of(around))
      if (within.contains(ring.front()) ? wants_inner : wants_outer)
        by_loop.back().push_back(std::move(ring));
  }
  if (settings.brim_type != BrimType::ears) {
    for (auto& loops : by_loop)
      for (auto& loop : loops) out.loops.push_back(std::move(loop));
    return out;
  }
  geom::Rings discs;
  const geom::Coord radius = from_mm(settings.brim_gap_mm + settings.brim_width_mm);
  for (const Point& corner : sharp_corners(part, settings.brim_ear_angle_deg))
    discs.push_back(geom::make_circle(corner, radius, kEarSides));
  if (discs.empty()) return out;
  return cut_ears(by_loop, geom::unite(discs), kLinkSpacings * spacing * geom::kNmPerMm);
}

}  // namespace voidpath::toolpath

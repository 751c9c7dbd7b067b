#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/fill/hatch.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::Point;
using std::numbers::pi;

/// Directions tried beside those of the area's own long edges.
constexpr int kDirections = 12;
constexpr std::size_t kEdgeDirections = 4;
/// Distance of the lines a direction is judged by: at most this, and at least this many across, mm.
constexpr double kProbeMm = 1.0;
constexpr double kProbesAcross = 6.0;
/// Slivers are judged by lines no closer than this, mm.
constexpr double kLeastProbeMm = 0.02;
/// Hold is looked for at this many places beyond a line's end.
constexpr geom::Coord kLooks = 4;
/// Share of a bridge's length that must hang between two held ends.
constexpr double kMinAnchoredShare = 0.7;
/// Directions whose anchored shares differ by less are equal; the shorter span wins.
constexpr double kSameShare = 0.02;
/// A strand whose middle is beside an edge by this share of a line width still lies on it.
constexpr double kOnEdge = 0.3;
/// Ground further from a bridge's area than this many line widths is no business of it.
constexpr double kNearWidths = 3.0;

struct Judgement {
  double share = 0;    ///< of the length, held at both ends
  double span_mm = 0;  ///< longest held line
};

/// Directions of the longest edges, in [0, π).
std::vector<double> edge_directions(const geom::Ring& ring) {
  std::vector<std::pair<double, double>> edges;  // length, direction
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point& a = ring[i];
    const Point& b = ring[(i + 1) % ring.size()];
    double angle = std::atan2(static_cast<double>(b.y - a.y), static_cast<double>(b.x - a.x));
    if (angle < 0) angle += pi;
    edges.emplace_back(geom::distance(a, b), angle >= pi ? angle - pi : angle);
  }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<double> out;
  for (std::size_t i = 0; i < std::min(kEdgeDirections, edges.size()); ++i) out.push_back(edges[i].second);
  return out;
}

/// Whether there is material under a line's end or up to `reach` beyond it: what holds may be no wider than
/// its walls.
bool finds_hold(const geom::AreaGrid& below, const Point& end, const Point& reach) {
  for (geom::Coord k = 1; k <= kLooks; ++k)
    if (below.contains({end.x + reach.x * k / kLooks, end.y + reach.y * k / kLooks})) return true;
  return false;
}

Judgement judge(const geom::Region& hanging, const geom::AreaGrid& below, double angle, double probe_mm,
                double reach_mm) {
  const double reach = reach_mm * geom::kNmPerMm;
  const Point step{std::llround(std::cos(angle) * reach), std::llround(std::sin(angle) * reach)};
  double all = 0;
  double held = 0;
  Judgement out;
  for (const auto& line : hatch({hanging}, {angle, probe_mm, false, 0}).lines) {
    const double length = geom::length(line);
    all += length;
    // Row lines run in the direction of the angle, from their first point to their last.
    const Point& a = line.front();
    const Point& b = line.back();
    if (!finds_hold(below, a, {-step.x, -step.y}) || !finds_hold(below, b, step)) continue;
    held += length;
    out.span_mm = std::max(out.span_mm, length / geom::kNmPerMm);
  }
  if (all > 0) out.share = held / all;
  return out;
}

}  // namespace

geom::Regions bridge_ground(const geom::Regions& below, const geom::Regions& area, double line_width_mm) {
  const auto box = geom::bounds(area);
  if (!box) return {};
  const geom::Coord near = geom::from_mm(kNearWidths * line_width_mm);
  const geom::Regions around{
      {geom::make_rectangle({box->min.x - near, box->min.y - near}, {box->max.x + near, box->max.y + near}),
       {}}};
  return geom::offset(quick_intersect(below, around), geom::from_mm(kOnEdge * line_width_mm));
}

BridgeArea plan_bridge(const geom::Region& hanging, const geom::Regions& below, double reach_mm) {
  BridgeArea out;
  out.hanging = hanging;
  const auto box = geom::bounds(hanging.outer);
  if (!box || below.empty()) return out;
  const double size = geom::to_mm(std::min(box->max.x - box->min.x, box->max.y - box->min.y));
  const double probe = std::clamp(size / kProbesAcross, kLeastProbeMm, kProbeMm);
  std::vector<double> directions = edge_directions(hanging.outer);
  for (int i = 0; i < kDirections; ++i) directions.push_back(pi * i / kDirections);
  const geom::AreaGrid grid(below);
  Judgement best{-1, 0};
  for (const double angle : directions) {
    const Judgement j = judge(hanging, grid, angle, probe, reach_mm);
    const bool same = std::abs(j.share - best.share) < kSameShare;
    if (same ? j.span_mm < best.span_mm : j.share > best.share) {
      best = j;
      out.angle_rad = angle;
    }
  }
  out.span_mm = best.span_mm;
  out.anchored = best.share >= kMinAnchoredShare;
  return out;
}

}  // namespace voidpath::toolpath

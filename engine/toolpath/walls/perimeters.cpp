#include "engine/toolpath/walls/perimeters.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/walls/border.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Neighbouring walls may come this close, as a share of their spacing, before the inner one is dropped
/// and the gap filled instead.
constexpr double kMinSpacingShare = 0.8;
/// Slivers thinner than this share of a bead are left to the squeeze of their neighbours.
constexpr double kMinGapShare = 0.2;
/// Slack for the rounding of offsets, nm, so that an area exactly as wide as a bead keeps its bead.
constexpr geom::Coord kOffsetSlack = 1000;
/// What lies between the innermost beads and is narrower than this, in spacings, is filled by a line down
/// its middle: lines across it would be short, and sparse ones would miss it.
constexpr double kMaxGapSpacings = 1.8;
/// Walls thinner than this are not there, mm.
constexpr double kLeastWallMm = 0.04;
/// Corners that turn by less than this cosine tells stand out by next to nothing.
constexpr double kSharpCosine = 0.8;
/// Corners may stand out by this, mm: a nozzle is not more precise.
constexpr double kStandsOutMm = 0.02;
/// Gap areas below this are noise of the offsetting, mm².
constexpr double kMinGapAreaMm2 = 0.02;

/// Whether a corner stands out further than by_mm inside the regions: where a short edge has vanished between
/// two others, growing back makes a sharper corner of them than there was.
bool stands_out(const Regions& grown, const Regions& regions, double by_mm) {
  std::optional<Border> border;  // made when first wanted
  const auto looks_at = [](const geom::Point& p, const geom::Point& q, const geom::Point& r) {
    const auto ux = static_cast<double>(q.x - p.x), uy = static_cast<double>(q.y - p.y);
    const auto vx = static_cast<double>(r.x - q.x), vy = static_cast<double>(r.y - q.y);
    return ux * vx + uy * vy < kSharpCosine * std::sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy)) &&
           ux * vy - uy * vx > 0;
  };
  for (const auto& region : grown)
    for (const auto& ring : geom::rings_of({region}))
      for (std::size_t i = 0, n = ring.size(); i < n; ++i) {
        if (!looks_at(ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n])) continue;
        if (!border) border.emplace(regions);
        if (border->distance_mm(ring[i], by_mm) < by_mm - kStandsOutMm) return true;
      }
  return false;
}

/// Shrinks, and drops what is too thin for two centre lines `min_spacing` apart.
Regions inset(const Regions& regions, double by_mm, double min_spacing_mm) {
  const geom::Coord back = std::max<geom::Coord>(from_mm(0.5 * min_spacing_mm) - kOffsetSlack, 0);
  Regions out = geom::offset(geom::offset(regions, -(from_mm(by_mm) + back)), back);
  if (stands_out(out, regions, by_mm)) out = quick_intersect(out, geom::offset(regions, -from_mm(by_mm)));
  return out;
}

/// What `beads` leave of `area`, without threads too thin to print.
void collect_gaps(Regions& gaps, const Regions& area, const Regions& beads, const BeadSize& bead) {
  Regions left = quick_subtract(area, beads);
  if (left.empty()) return;
  left = geom::open(left, from_mm(0.5 * kMinGapShare * bead.width_mm));
  append(gaps, geom::remove_small(left, kMinGapAreaMm2 * geom::kNmPerMm * geom::kNmPerMm));
}

bool inside(const geom::Ring& inner, const geom::Ring& outer) { return geom::contains(outer, inner.front()); }

/// The wall whose deepest loop is the neighbour of this one, one step further out.
Wall* find_wall(std::vector<Wall>& walls, const Loop& loop) {
  for (Wall& wall : walls) {
    const Loop& last = wall.back();
    if (last.depth + 1 != loop.depth || last.is_hole != loop.is_hole) continue;
    if (loop.is_hole ? inside(last.ring, loop.ring) : inside(loop.ring, last.ring)) return &wall;
  }
  return nullptr;
}

void add_loops(std::vector<Wall>& walls, const Regions& centre_lines, int depth) {
  auto add = [&](const geom::Ring& ring, bool is_hole) {
    Loop loop{ring, depth, is_hole};
    if (Wall* wall = depth > 0 ? find_wall(walls, loop) : nullptr)
      wall->push_back(std::move(loop));
    else
      walls.push_back({std::move(loop)});
  };
  for (const auto& region : centre_lines) {
    add(region.outer, false);
    for (const auto& hole : region.holes) add(hole, true);
  }
}

}  // namespace

double BeadSize::spacing_mm() const { return bead_spacing_mm(width_mm, height_mm); }
double BeadSize::area_mm2() const { return bead_area_mm2(width_mm, height_mm); }

BeadSize bead_of_layer(const SliceSettings& settings, std::size_t layer, double height_mm) {
  return {layer == 0 ? settings.first_layer_line_width_mm : settings.line_width_mm, height_mm};
}

Perimeters make_perimeters(const geom::Region& outline, int count, const BeadSize& bead) {
  Perimeters out;
  const double spacing = bead.spacing_mm();
  const double min_spacing = kMinSpacingShare * spacing;
  Regions area{outline};  // not yet under a bead
  Regions centre;
  for (int depth = 0; depth < count && !area.empty(); ++depth) {
    const double half = 0.5 * (depth == 0 ? bead.width_mm : spacing);
    centre = inset(area, half, min_spacing);
    if (depth == 0 && centre.empty()) {
      out.thin = geom::open(area, from_mm(0.5 * kLeastWallMm));
      return out;
    }
    collect_gaps(out.gaps, area, geom::offset(centre, from_mm(half) + kOffsetSlack), bead);
    if (depth == 0) out.at_outline = out.gaps.size();
    add_loops(out.walls, centre, depth);
    area = geom::offset(centre, -from_mm(0.5 * spacing));
  }
  if (area.empty()) return out;
  // Without walls the fill's lines keep half a width inside the outline: none may fit a strip narrower than
  // this.
  const double least = count > 0 ? kMaxGapSpacings * spacing : bead.width_mm + spacing;
  out.inner = std::move(area);
  take_strips(out.gaps, out.inner, least, bead);
  if (count == 0) out.inner = quick_intersect(out.inner, {outline});
  if (count <= 0) out.at_outline = out.gaps.size();
  return out;
}

void take_strips(Regions& strips, Regions& area, double least_mm, const BeadSize& bead) {
  Regions wide = geom::open(area, std::max<geom::Coord>(from_mm(0.5 * least_mm) - kOffsetSlack, 0));
  collect_gaps(strips, area, wide, bead);
  area = std::move(wide);
}

}  // namespace voidpath::toolpath

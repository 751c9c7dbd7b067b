#include "engine/toolpath/outline.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"

#include <numbers>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Rounding of offsets, nm: what is left over by less is not thin, but nothing.
constexpr geom::Coord kOffsetSlack = 5000;
/// Thin features keep their width this much further than their root, in compensations: otherwise the
/// shrunk body would draw back from them.
constexpr double kRootReach = 1.5;
/// Corners of what grows reach this much further than its sides: right angles stay sharp, sharper ones are
/// cut off there.
constexpr double kCornerReach = std::numbers::sqrt2;

/// By a compensation, which may be negative.
Regions compensated_by(const Regions& regions, double mm) {
  const Regions out = geom::offset(regions, from_mm(mm));
  if (!(mm > 0)) return out;
  return quick_intersect(out, geom::offset(regions, from_mm(kCornerReach * mm), geom::Join::round));
}

}  // namespace

Regions compensated(const Regions& regions, double outer_mm, double hole_mm) {
  if (outer_mm == 0 && hole_mm == 0) return regions;
  Regions out;
  for (const auto& region : regions) {
    Regions body = compensated_by({{region.outer, {}}}, outer_mm);
    Regions holes;
    for (geom::Ring hole : region.holes) {
      geom::reverse(hole);
      holes.push_back({std::move(hole), {}});
    }
    append(out, quick_subtract(body, compensated_by(holes, hole_mm)));
  }
  // Neighbours may have grown into one another.
  return out.size() > 1 ? geom::unite(geom::rings_of(out)) : out;
}

Regions without_foot(const Regions& regions, double by_mm, double width_mm) {
  if (!(by_mm > 0)) return regions;
  const Regions shrunk = geom::offset(regions, -from_mm(by_mm));
  const Regions wide = geom::open(regions, from_mm(by_mm + 0.5 * width_mm));
  Regions thin = geom::open(quick_subtract(regions, geom::offset(wide, kOffsetSlack)), kOffsetSlack);
  if (thin.empty()) return shrunk;
  thin = quick_intersect(geom::offset(thin, from_mm(kRootReach * by_mm)), regions);
  return quick_unite(shrunk, thin);
}

slice::LayerStack outlines(const slice::LayerStack& cuts, const SliceSettings& settings,
                           const run::Context& ctx) {
  slice::LayerStack out(cuts.size());
  run::parallel_for(ctx, cuts.size(), [&](std::size_t i) {
    out[i].span = cuts[i].span;
    Regions& regions = out[i].regions;
    regions = settings.resolution_mm > 0 ? geom::simplify(cuts[i].regions, from_mm(settings.resolution_mm))
                                         : cuts[i].regions;
    regions = compensated(regions, settings.xy_compensation_mm, settings.hole_compensation_mm);
    if (i == 0)
      regions = without_foot(regions, settings.elephant_foot_mm, settings.first_layer_line_width_mm);
  });
  return out;
}

}  // namespace voidpath::toolpath

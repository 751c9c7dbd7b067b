#include "engine/toolpath/overhang/unheld.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_task.h"

#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Strands hold on to what lies this far beside, mm.
constexpr double kAnchorMm = 1.2;
/// What is narrower than this many widths hangs from the lines beside it.
constexpr double kMinBridgeWidths = 0.5;

void bridge(Surfaces& own, const Regions& below, const Regions& support, const SliceSettings& settings) {
  Regions loose = support.empty()
                      ? std::move(own.unheld)
                      : quick_subtract(own.unheld, geom::offset(support, from_mm(kBesideSupportMm)));
  loose = geom::open(loose, from_mm(0.5 * kMinBridgeWidths * settings.line_width_mm));
  for (const geom::Region& region : loose) {
    const double walls = settings.line_width_mm * settings.perimeters;
    BridgeArea out = plan_bridge(region, below, walls + 0.5 * kAnchorMm);
    out.hanging = region;
    out.area = quick_intersect(geom::offset({region}, from_mm(kAnchorMm)), quick_unite(own.solid, own.top));
    if (out.area.empty()) continue;
    out.ground = bridge_ground(below, out.area, settings.line_width_mm);
    own.solid = quick_subtract(own.solid, out.area);
    own.top = quick_subtract(own.top, out.area);
    own.bridges.push_back(std::move(out));
  }
}

}  // namespace

void bridge_unheld(std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
                   const std::vector<SupportAreas>& supports, const SliceSettings& settings,
                   const run::Context& ctx) {
  run::parallel_for(ctx, surfaces.size(), [&](std::size_t i) {
    if (i == 0 || surfaces[i].unheld.empty()) return;
    const std::size_t bearer = layer_below_gap(stack, i, settings.support_z_gap_mm);
    if (bearer >= supports.size()) return;  // the plate is as near as a support would be
    bridge(surfaces[i], stack[i - 1].regions, printed_area(supports[bearer]), settings);
  });
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/fill/internal_bridges.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Gaps between lines of infill narrower than this, in line widths, are carried across by any bead.
constexpr double kMinGapWidths = 1.5;
/// Stretches over sparse infill narrower than this, in line widths, hold on to the solid beside them.
constexpr double kMinHangingWidths = 2.0;
/// A solid region that hangs by more than this share is bridged as a whole.
constexpr double kAllHanging = 0.7;
/// Lines reach this far onto the solid beside, mm.
constexpr double kAnchorMm = 1.0;

bool has_gaps(const SliceSettings& settings) {
  const double density = settings.infill_density;
  return density < 1.0 && (density <= 0 || 1.0 / density - 1.0 > kMinGapWidths);
}

/// The part of one solid region that hangs becomes bridges; the rest stays in `solid`.
void take_hanging(const geom::Region& region, const Regions& sparse, const Regions& walls,
                  const SliceSettings& settings, Surfaces& own, Regions& solid) {
  Regions hanging = quick_intersect({region}, sparse);
  if (!hanging.empty())
    hanging = geom::open(hanging, from_mm(0.5 * kMinHangingWidths * settings.line_width_mm));
  Regions rest{region};
  const bool all = geom::area(hanging) > kAllHanging * geom::area(region);
  for (const geom::Region& part : hanging) {
    BridgeArea bridge;
    if (!walls.empty()) bridge = plan_bridge(part, walls, 0.5 * kAnchorMm);
    bridge.hanging = part;
    bridge.area =
        all && hanging.size() == 1 ? rest : quick_intersect(geom::offset({part}, from_mm(kAnchorMm)), rest);
    rest = quick_subtract(rest, bridge.area);
    if (!bridge.area.empty()) own.internal_bridges.push_back(std::move(bridge));
  }
  append(solid, std::move(rest));
}

void find_in(std::size_t i, std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
             const SliceSettings& settings) {
  Surfaces& own = surfaces[i];
  const Regions& sparse = surfaces[i - 1].sparse;
  if (own.solid.empty() || sparse.empty()) return;
  Regions walls;  // what holds over a hollow
  if (settings.infill_density <= 0) walls = quick_subtract(stack[i - 1].regions, sparse);
  Regions solid;
  for (const geom::Region& region : own.solid) take_hanging(region, sparse, walls, settings, own, solid);
  own.solid = std::move(solid);
}

}  // namespace

void find_internal_bridges(std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
                           const SliceSettings& settings, const run::Context& ctx) {
  if (!has_gaps(settings)) return;
  // Sparse areas stay as they are, so that layers can be looked at in any order.
  run::parallel_for(ctx, surfaces.size(), [&](std::size_t i) {
    if (i > 0) find_in(i, surfaces, stack, settings);
  });
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/fill/combine_infill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Shared areas narrower than this, in line widths, are not worth a line of their own; nor is what is left
/// of a layer's beside them.
constexpr double kMinWidths = 2.0;
/// Heights that differ by less are equal, mm.
constexpr double kSameHeightMm = 1e-6;

void combine(const InfillGroup& group, std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
             const SliceSettings& settings) {
  const std::size_t last = group.first + group.count - 1;
  geom::Regions common = surfaces[group.first].sparse;
  for (std::size_t i = group.first + 1; i <= last && !common.empty(); ++i)
    common = quick_intersect(common, surfaces[i].sparse);
  const geom::Coord radius = from_mm(0.5 * kMinWidths * settings.line_width_mm);
  if (!common.empty()) common = geom::open(common, radius);
  common = geom::remove_small(common, settings.min_infill_area_mm2 * geom::kNmPerMm * geom::kNmPerMm);
  if (common.empty()) return;
  for (std::size_t i = group.first; i <= last; ++i) {
    geom::Regions& sparse = surfaces[i].sparse;
    sparse = quick_subtract(sparse, common);
    if (!sparse.empty()) sparse = geom::open(sparse, radius);
  }
  surfaces[last].thick = std::move(common);
  surfaces[last].thick_mm = stack[last].span.top_mm - stack[group.first].span.bottom_mm;
}

}  // namespace

std::vector<InfillGroup> infill_groups(const slice::LayerStack& stack, const PrintSettings& settings) {
  std::vector<InfillGroup> out;
  const auto most = static_cast<std::size_t>(std::max(settings.slice.infill_every_layers, 1));
  const double limit = settings.machine.nozzle_mm + kSameHeightMm;
  for (std::size_t first = 1; first < stack.size();) {
    InfillGroup group{first, 1};
    while (group.count < most && first + group.count < stack.size() &&
           stack[first + group.count].span.top_mm - stack[first].span.bottom_mm <= limit)
      ++group.count;
    out.push_back(group);
    first += group.count;
  }
  return out;
}

void combine_infill(std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
                    const PrintSettings& settings, const run::Context& ctx) {
  if (settings.slice.infill_every_layers <= 1 || settings.slice.infill_pattern == InfillPattern::lightning)
    return;
  const std::vector<InfillGroup> groups = infill_groups(stack, settings);
  run::parallel_for(ctx, groups.size(), [&](std::size_t g) {
    for (std::size_t i = groups[g].first; i < groups[g].first + groups[g].count; ++i) surfaces[i].group = g;
    if (groups[g].count > 1) combine(groups[g], surfaces, stack, settings.slice);
  });
}

}  // namespace voidpath::toolpath

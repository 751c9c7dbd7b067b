#include "engine/toolpath/build.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/adhesion.h"
#include "engine/toolpath/combine_infill.h"
#include "engine/toolpath/draft.h"
#include "engine/toolpath/fill_directions.h"
#include "engine/toolpath/lightning.h"
#include "engine/toolpath/overhangs.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/sequence.h"
#include "engine/toolpath/supports.h"
#include "engine/toolpath/surfaces.h"

#include <algorithm>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// The outlines to print: the cuts at the resolution asked, the first layer less its elephant foot.
slice::LayerStack outlines(const slice::LayerStack& stack, const SliceSettings& settings,
                           const run::Context& ctx) {
  slice::LayerStack out(stack.size());
  run::parallel_for(ctx, stack.size(), [&](std::size_t i) {
    out[i].span = stack[i].span;
    out[i].regions = settings.resolution_mm > 0
                         ? geom::simplify(stack[i].regions, from_mm(settings.resolution_mm))
                         : stack[i].regions;
    if (i == 0 && settings.elephant_foot_mm > 0)
      out[i].regions = geom::offset(out[i].regions, -from_mm(settings.elephant_foot_mm));
  });
  return out;
}

void add_rings(std::vector<Path>& out, geom::Rings&& rings, const BeadSize& bead) {
  for (auto& ring : rings) {
    Path path;
    path.role = Role::skirt_brim;
    path.points = std::move(ring);
    path.closed = true;
    path.width_mm = bead.width_mm;
    path.height_mm = bead.height_mm;
    path.area_mm2 = bead.area_mm2();
    out.push_back(std::move(path));
  }
}

/// Skirt and brim, on the drafts of the layers that have them.
void draft_adhesion(std::vector<LayerDraft>& drafts, const slice::LayerStack& stack,
                    const std::vector<SupportAreas>& supports, const SliceSettings& settings) {
  geom::Regions footprint = stack[0].regions;
  footprint = quick_unite(footprint, supports[0].sparse);
  footprint = quick_unite(footprint, supports[0].interface);
  const BeadSize first = bead_of_layer(settings, 0, stack[0].span.height_mm());
  geom::Rings brim = brim_loops(footprint, settings, first);
  geom::Regions widened = footprint;
  if (!brim.empty()) widened = geom::offset(footprint, from_mm(settings.brim_width_mm), geom::Join::round);
  for (std::size_t i = 0;
       i < drafts.size() && i < static_cast<std::size_t>(std::max(settings.skirt_layers, 0)); ++i) {
    const BeadSize bead = bead_of_layer(settings, i, stack[i].span.height_mm());
    add_rings(drafts[i].around, skirt_loops(widened, settings, bead), bead);
  }
  add_rings(drafts[0].around, std::move(brim), first);
}

}  // namespace

Plan build(const slice::LayerStack& cuts, const PrintSettings& settings, const run::Context& ctx) {
  Plan plan;
  const std::size_t n = cuts.size();
  if (n == 0) return plan;
  const SliceSettings& s = settings.slice;
  slice::LayerStack stack = outlines(cuts, s, ctx);

  std::vector<LayerWalls> walls(n);
  std::vector<geom::Regions> inner(n);
  run::parallel_for(ctx, n, [&](std::size_t i) {
    walls[i] = draft_walls(stack[i], i, s);
    inner[i] = inner_of(walls[i]);
  });
  ctx.progress("toolpaths", 0.3);
  std::vector<Surfaces> surfaces = find_surfaces(stack, inner, s, ctx);
  ctx.progress("toolpaths", 0.5);
  const std::vector<SupportAreas> supports = find_supports(stack, surfaces, s, ctx);
  std::vector<geom::Polylines> lightning(n);
  if (s.infill_pattern == InfillPattern::lightning) lightning = lightning_lines(surfaces, stack, s, ctx);
  combine_infill(surfaces, stack, settings, ctx);
  const std::vector<FillDirections> directions = choose_directions(surfaces, settings, ctx);
  ctx.progress("toolpaths", 0.7);

  std::vector<LayerDraft> drafts(n);
  std::vector<BeadSize> beads(n);
  run::parallel_for(ctx, n, [&](std::size_t i) {
    beads[i] = walls[i].bead;
    drafts[i] = draft_layer(stack[i], i, std::move(walls[i]), surfaces[i], directions[i], lightning[i],
                            supports[i], settings);
  });
  draft_adhesion(drafts, stack, supports, s);
  ctx.progress("toolpaths", 0.9);

  plan.layers.resize(n);
  Sequencer sequencer(settings);
  for (std::size_t i = 0; i < n; ++i) {
    ctx.check();
    plan.layers[i].span = stack[i].span;
    plan.layers[i].paths = sequencer.order(std::move(drafts[i]), beads[i]);
  }
  std::vector<geom::Regions> supported(n);
  run::parallel_for(ctx, n, [&](std::size_t i) {
    if (i > 0)
      mark_overhangs(plan.layers[i].paths, stack[i].regions, stack[i - 1].regions, beads[i].width_mm,
                     settings.speed);
    supported[i] = quick_unite(supports[i].sparse, supports[i].interface);
  });
  for (std::size_t i = 0; i < n; ++i) {
    plan.layers[i].outline = std::move(stack[i].regions);
    plan.layers[i].support = std::move(supported[i]);
  }
  ctx.progress("toolpaths", 1.0);
  return plan;
}

void place_on_bed(slice::LayerStack& stack, const MachineShape& machine) {
  if (machine.origin_at_centre) return;
  const geom::Point middle{from_mm(machine.bed_mm[0] / 2), from_mm(machine.bed_mm[1] / 2)};
  for (auto& layer : stack) geom::translate(layer.regions, middle);
}

}  // namespace voidpath::toolpath

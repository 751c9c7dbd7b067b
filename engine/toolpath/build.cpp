#include "engine/toolpath/build.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/adhesion.h"
#include "engine/toolpath/bare.h"
#include "engine/toolpath/brim.h"
#include "engine/toolpath/combine_infill.h"
#include "engine/toolpath/draft.h"
#include "engine/toolpath/fill_directions.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/lightning.h"
#include "engine/toolpath/outline.h"
#include "engine/toolpath/overhangs.h"
#include "engine/toolpath/raft.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/sequence.h"
#include "engine/toolpath/spiral_vase.h"
#include "engine/toolpath/support_task.h"
#include "engine/toolpath/supports.h"
#include "engine/toolpath/surfaces.h"
#include "engine/toolpath/threads.h"
#include "engine/toolpath/tips.h"
#include "engine/toolpath/trim_support.h"
#include "engine/toolpath/unheld.h"

#include <algorithm>
#include <span>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

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

/// Skirt and brim, on the drafts of the layers that have them. `drafts` and `beads` begin with the raft's.
void draft_adhesion(std::vector<LayerDraft>& drafts, const std::vector<BeadSize>& beads,
                    const slice::LayerStack& stack, const std::vector<SupportAreas>& supports,
                    const geom::Regions& footprint, const Raft& raft, const SliceSettings& settings) {
  geom::Regions around = raft.layers.empty() ? footprint : raft.area;
  Brim brim = make_brim(footprint, stack[0].regions, settings, beads[0]);
  if (!brim.loops.empty() || !brim.ears.empty())
    around =
        geom::offset(footprint, from_mm(settings.brim_gap_mm + settings.brim_width_mm), geom::Join::round);
  // A skirt of several layers stays clear of what grows out above the plate.
  const auto skirts = std::min(drafts.size(), static_cast<std::size_t>(std::max(settings.skirt_layers, 0)));
  for (std::size_t k = raft.layers.size() + 1; k < skirts; ++k) {
    const std::size_t i = k - raft.layers.size();
    append(around, geom::Regions(stack[i].regions));
    append(around, printed_area(supports[i]));
  }
  for (std::size_t k = 0; k < skirts; ++k)
    add_rings(drafts[k].around, skirt_loops(around, settings, beads[k]), beads[k]);
  add_rings(drafts[0].around, std::move(brim.loops), beads[0]);
  for (auto& ear : brim.ears)
    drafts[0].around.push_back(make_path(Role::skirt_brim, std::move(ear), false, beads[0].width_mm,
                                         beads[0].height_mm, beads[0].area_mm2()));
}

/// Supports with groups of layers as layers, each of the outline of its sample. A thick layer's z gap would
/// take a whole group off a column, so none is kept.
std::vector<SupportAreas> find_supports_of_groups(const slice::LayerStack& stack,
                                                  const std::vector<LayerGroup>& groups,
                                                  const std::vector<geom::Regions>& inner,
                                                  const SliceSettings& settings, const run::Context& ctx,
                                                  std::vector<double>& dense_mm2) {
  if (settings.support == SupportMode::none) return std::vector<SupportAreas>(groups.size());
  slice::LayerStack thick(groups.size());
  std::vector<geom::Regions> thick_inner(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const LayerGroup& group = groups[g];
    // From sample to sample, so that what leans out is judged by the way between the two outlines.
    const double bottom_mm = g == 0 ? 0 : thick[g - 1].span.top_mm;
    thick[g].span = {bottom_mm, g == 0 ? stack[0].span.top_mm : stack[group.sample].span.cut_mm()};
    thick[g].regions = stack[group.sample].regions;
    thick_inner[g] = inner[group.sample];
  }
  SliceSettings gapless = settings;
  gapless.support_z_gap_mm = 0;
  // Bridges need the layer that begins them, which is seldom a sample.
  const std::vector<Surfaces> surfaces = find_surfaces(thick, thick_inner, gapless, ctx);
  std::vector<SupportAreas> out = find_supports(thick, surfaces, gapless, ctx);
  const auto interface_layers = static_cast<std::size_t>(std::max(settings.support_interface_layers, 0));
  for (std::size_t g = 0; g < out.size(); ++g) {
    out[g].sparse = quick_unite(out[g].sparse, out[g].floor);
    out[g].floor.clear();
    dense_mm2[g] = geom::area(out[g].interface) / (geom::kNmPerMm * geom::kNmPerMm);
    if (groups[g].count <= interface_layers) continue;
    out[g].sparse = quick_unite(out[g].sparse, out[g].interface);
    out[g].interface.clear();
  }
  return out;
}

}  // namespace

SampledPlan build_samples(const slice::LayerStack& cuts, const std::vector<LayerGroup>& groups,
                          const PrintSettings& settings, const run::Context& ctx) {
  SampledPlan out;
  Plan& plan = out.plan;
  const std::size_t n = groups.size();
  out.dense_mm2.resize(n);
  if (n == 0) return out;
  PrintSettings part = settings;
  part.slice = above_raft(settings.slice);
  const SliceSettings& s = part.slice;
  slice::LayerStack stack = outlines(cuts, s, ctx);

  std::vector<LayerWalls> walls(n);
  std::vector<geom::Regions> inner(stack.size());
  run::parallel_for(ctx, n, [&](std::size_t g) {
    const std::size_t i = groups[g].sample;
    walls[g] = draft_walls(stack[i], i, s);
    inner[i] = inner_of(walls[g]);
  });
  ctx.progress("toolpaths", 0.3);
  std::vector<Surfaces> surfaces = find_surfaces(stack, inner, s, ctx);
  ctx.progress("toolpaths", 0.5);
  const std::vector<SupportAreas> supports =
      n == stack.size() ? find_supports(stack, surfaces, s, ctx)
                        : find_supports_of_groups(stack, groups, inner, s, ctx, out.dense_mm2);
  if (n == stack.size()) bridge_unheld(surfaces, stack, supports, s, ctx);
  std::vector<geom::Polylines> lightning(stack.size());
  if (s.infill_pattern == InfillPattern::lightning) lightning = lightning_lines(surfaces, stack, s, ctx);
  combine_infill(surfaces, stack, part, ctx);
  const std::vector<FillDirections> directions = choose_directions(surfaces, part, ctx);
  ctx.progress("toolpaths", 0.7);

  const geom::Regions footprint = quick_unite(stack[0].regions, printed_area(supports[0]));
  Raft raft = make_raft(footprint, settings.slice);
  const std::size_t below = raft.layers.size();
  std::vector<LayerDraft> drafts(below + n);
  std::vector<BeadSize> beads(below + n);
  for (std::size_t k = 0; k < below; ++k) {
    drafts[k].support = std::move(raft.layers[k].lines);
    beads[k] = raft.layers[k].bead;
  }
  run::parallel_for(ctx, n, [&](std::size_t g) {
    const std::size_t i = groups[g].sample;
    beads[below + g] = walls[g].bead;
    drafts[below + g] = draft_layer(stack[i], i, std::move(walls[g]), surfaces[i], directions[i],
                                    lightning[i], supports[g], part);
  });
  if (n == stack.size() && s.support != SupportMode::none && s.support_style == SupportStyle::grid) {
    std::vector<std::vector<Path>*> lines;
    for (std::size_t i = 0; i < n; ++i) lines.push_back(&drafts[below + i].support);
    trim_support(lines, stack, s, ctx);
  }
  if (below > 0) stand_on_raft(drafts[below].support, settings.slice);
  draft_adhesion(drafts, beads, stack, supports, footprint, raft, s);
  ctx.progress("toolpaths", 0.9);

  plan.layers.resize(below + n);
  Sequencer sequencer(part, ctx);
  for (std::size_t k = 0; k < below + n; ++k) {
    ctx.check();
    LayerPlan& layer = plan.layers[k];
    layer.paths = sequencer.order(std::move(drafts[k]), beads[k]);
    if (k < below) {
      layer.span = raft.layers[k].span;
      layer.support = raft.area;
    } else {
      layer.span = stack[groups[k - below].sample].span;
      layer.span.bottom_mm += raft.lift_mm;
      layer.span.top_mm += raft.lift_mm;
    }
  }
  run::parallel_for(ctx, n, [&](std::size_t g) {
    const std::size_t i = groups[g].sample;
    LayerPlan& layer = plan.layers[below + g];
    if (i > 0) {
      const std::size_t bearer = layer_below_gap(stack, i, s.support_z_gap_mm);
      if (n == stack.size() && bearer < n)
        hold_tips(layer.paths, stack[i].regions, stack[i - 1].regions, printed_area(supports[bearer]));
    }
  });
  std::vector<geom::Regions> bare(stack.size());
  if (n == stack.size()) {
    run::parallel_for(ctx, n,
                      [&](std::size_t i) { bare[i] = bare_parts(walls[i], plan.layers[below + i].paths); });
    cut_threads(std::span(plan.layers).subspan(below), stack, supports, bare, s, ctx);
  }
  run::parallel_for(ctx, n, [&](std::size_t g) {
    const std::size_t i = groups[g].sample;
    LayerPlan& layer = plan.layers[below + g];
    if (i > 0) {
      const double width = beads[below + g].width_mm;
      mark_overhangs(layer.paths, stack[i].regions, stack[i - 1].regions, bare[i - 1], width, settings.speed);
    }
    layer.support = printed_area(supports[g]);
  });
  for (std::size_t g = 0; g < n; ++g)
    plan.layers[below + g].outline = std::move(stack[groups[g].sample].regions);
  for (Path& path : plan.layers[0].paths) path.area_mm2 *= settings.filament.first_layer_flow;
  ctx.progress("toolpaths", 1.0);
  return out;
}

Plan build(const slice::LayerStack& cuts, const PrintSettings& settings, const run::Context& ctx) {
  if (settings.slice.spiral_vase) return build_vase(cuts, settings, ctx);
  std::vector<LayerGroup> each(cuts.size());
  for (std::size_t i = 0; i < each.size(); ++i) each[i] = {i, 1, i};
  return build_samples(cuts, each, settings, ctx).plan;
}

void place_on_bed(slice::LayerStack& stack, const MachineShape& machine) {
  if (machine.origin_at_centre) return;
  const geom::Point middle{from_mm(machine.bed_mm[0] / 2), from_mm(machine.bed_mm[1] / 2)};
  for (auto& layer : stack) geom::translate(layer.regions, middle);
}

}  // namespace voidpath::toolpath

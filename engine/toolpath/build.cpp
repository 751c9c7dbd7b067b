#include "engine/toolpath/build.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/adhesion/adhesion.h"
#include "engine/toolpath/adhesion/brim.h"
#include "engine/toolpath/adhesion/raft.h"
#include "engine/toolpath/draft.h"
#include "engine/toolpath/fill/combine_infill.h"
#include "engine/toolpath/fill/fill_directions.h"
#include "engine/toolpath/fill/lightning.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/outline.h"
#include "engine/toolpath/overhang/bare.h"
#include "engine/toolpath/overhang/hanging_fill.h"
#include "engine/toolpath/overhang/overhangs.h"
#include "engine/toolpath/overhang/threads.h"
#include "engine/toolpath/overhang/tips.h"
#include "engine/toolpath/overhang/unheld.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/spiral_vase.h"
#include "engine/toolpath/support/support_task.h"
#include "engine/toolpath/support/supports.h"
#include "engine/toolpath/support/trim_support.h"
#include "engine/toolpath/travel/sequence.h"

#include <algorithm>
#include <optional>
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

/// A plan on its way: what each step leaves for the next.
class Builder {
 public:
  Builder(const slice::LayerStack& cuts, const std::vector<LayerGroup>& groups, const PrintSettings& settings,
          const run::Context& ctx)
      : groups_(groups),
        n_(groups.size()),
        settings_(settings),
        part_(settings),
        ctx_(ctx),
        walls_(n_),
        dense_mm2_(n_) {
    part_.slice = above_raft(settings.slice);
    stack_ = outlines(cuts, slice(), ctx);
    whole_ = n_ == stack_.size();
  }

  SampledPlan run() {
    find_areas();
    draft();
    put_in_order();
    mind_the_air();
    for (std::size_t g = 0; g < n_; ++g) layer(g).outline = std::move(stack_[groups_[g].sample].regions);
    for (Path& path : plan_.layers[0].paths) path.area_mm2 *= settings_.filament.first_layer_flow;
    ctx_.progress("toolpaths", 1.0);
    return {std::move(plan_), std::move(dense_mm2_)};
  }

 private:
  const SliceSettings& slice() const { return part_.slice; }
  std::size_t below() const { return raft_.layers.size(); }
  LayerPlan& layer(std::size_t g) { return plan_.layers[below() + g]; }

  /// Of every layer: walls, surfaces, supports, and how its areas are filled.
  void find_areas() {
    std::vector<geom::Regions> inner(stack_.size());
    run::parallel_for(ctx_, n_, [&](std::size_t g) {
      const std::size_t i = groups_[g].sample;
      walls_[g] = draft_walls(stack_[i], i, slice());
      inner[i] = inner_of(walls_[g]);
    });
    ctx_.progress("toolpaths", 0.3);
    surfaces_ = find_surfaces(stack_, inner, slice(), ctx_);
    ctx_.progress("toolpaths", 0.5);
    supports_ = whole_ ? find_supports(stack_, surfaces_, slice(), ctx_)
                       : find_supports_of_groups(stack_, groups_, inner, slice(), ctx_, dense_mm2_);
    if (whole_) bridge_unheld(surfaces_, stack_, supports_, slice(), ctx_);
    lightning_.resize(stack_.size());
    if (slice().infill_pattern == InfillPattern::lightning)
      lightning_ = lightning_lines(surfaces_, stack_, slice(), ctx_);
    combine_infill(surfaces_, stack_, part_, ctx_);
    directions_ = choose_directions(surfaces_, part_, ctx_);
    ctx_.progress("toolpaths", 0.7);
  }

  /// Every layer's lines, the raft's first.
  void draft() {
    const geom::Regions footprint = quick_unite(stack_[0].regions, printed_area(supports_[0]));
    raft_ = make_raft(footprint, settings_.slice);
    plan_.layers.resize(below() + n_);
    drafts_.resize(below() + n_);
    beads_.resize(below() + n_);
    for (std::size_t k = 0; k < below(); ++k) {
      drafts_[k].support = std::move(raft_.layers[k].lines);
      beads_[k] = raft_.layers[k].bead;
    }
    run::parallel_for(ctx_, n_, [&](std::size_t g) {
      const std::size_t i = groups_[g].sample;
      beads_[below() + g] = walls_[g].bead;
      drafts_[below() + g] = draft_layer(stack_[i], i, walls_[g], surfaces_[i], directions_[i], lightning_[i],
                                         supports_[g], part_);
      layer(g).support = printed_area(supports_[g]);
    });
    if (whole_ && slice().support != SupportMode::none && slice().support_style == SupportStyle::grid) {
      std::vector<std::vector<Path>*> lines;
      for (std::size_t i = 0; i < n_; ++i) lines.push_back(&drafts_[below() + i].support);
      trim_support(lines, stack_, slice(), ctx_);
    }
    if (below() > 0) stand_on_raft(drafts_[below()].support, settings_.slice);
    draft_adhesion(drafts_, beads_, stack_, supports_, footprint, raft_, slice());
    ctx_.progress("toolpaths", 0.9);
  }

  /// One layer after the other, each from where the one below ended; its tips are held as soon as it is
  /// there.
  void put_in_order() {
    bare_.resize(stack_.size());
    Sequencer sequencer(part_, ctx_);
    const auto order = [&](std::size_t k) {
      LayerPlan& layer = plan_.layers[k];
      layer.paths = sequencer.order(std::move(drafts_[k]), beads_[k]);
      if (k < below()) {
        layer.span = raft_.layers[k].span;
        layer.support = raft_.area;
      } else {
        layer.span = stack_[groups_[k - below()].sample].span;
        layer.span.bottom_mm += raft_.lift_mm;
        layer.span.top_mm += raft_.lift_mm;
      }
    };
    run::parallel_after(ctx_, plan_.layers.size(), order, [&](std::size_t k) {
      if (whole_ && k >= below()) hold_tips_of(k - below());
    });
  }

  void hold_tips_of(std::size_t i) {
    const std::size_t bearer = i > 0 ? layer_below_gap(stack_, i, slice().support_z_gap_mm) : n_;
    if (bearer < n_)
      hold_tips(layer(i).paths, stack_[i].regions, stack_[i - 1].regions, layer(bearer).support);
    // Over an equal outline the same lines lie: nothing of them is over what is bare.
    if (i + 1 < n_ && stack_[i + 1].regions != stack_[i].regions)
      bare_[i] = bare_parts(walls_[i], layer(i).paths, stack_[i].regions);
  }

  /// What still would hang is cut back, or told as an overhang.
  void mind_the_air() {
    if (whole_) cut_threads(std::span(plan_.layers).subspan(below()), stack_, bare_, slice(), ctx_);
    // Looks at the lines of other layers, which none may change meanwhile.
    std::vector<std::optional<std::vector<Path>>> bridged(n_);
    if (whole_ && slice().support_interface_layers > 0)
      run::parallel_for(ctx_, n_, [&](std::size_t i) { bridged[i] = bridge_hanging_fill_of(i); });
    run::parallel_for(ctx_, n_, [&](std::size_t g) {
      const std::size_t i = groups_[g].sample;
      if (bridged[g]) layer(g).paths = std::move(*bridged[g]);
      if (i > 0)
        mark_overhangs(layer(g).paths, stack_[i].regions, stack_[i - 1].regions, bare_[i - 1],
                       beads_[below() + g].width_mm, settings_.speed);
    });
  }

  /// Over dense support alone: what lies between sparse lines is held as far as was asked for.
  std::optional<std::vector<Path>> bridge_hanging_fill_of(std::size_t i) {
    if (i == 0 || surfaces_[i].unheld.empty()) return std::nullopt;
    const std::size_t bearer = layer_below_gap(stack_, i, slice().support_z_gap_mm);
    if (bearer >= n_) return std::nullopt;  // the plate is as near as a support would be
    return bridge_hanging_fill(layer(i).paths, surfaces_[i].unheld, stack_[i - 1].regions,
                               layer(bearer).paths, lean_mm(slice(), stack_[i].span.height_mm()));
  }

  const std::vector<LayerGroup>& groups_;
  std::size_t n_;
  const PrintSettings& settings_;
  PrintSettings part_;  ///< of what lies above the raft
  const run::Context& ctx_;
  slice::LayerStack stack_;
  bool whole_ = false;  ///< every layer is planned
  std::vector<LayerWalls> walls_;
  std::vector<Surfaces> surfaces_;
  std::vector<SupportAreas> supports_;
  std::vector<geom::Polylines> lightning_;
  std::vector<FillDirections> directions_;
  Raft raft_;
  std::vector<LayerDraft> drafts_;  ///< the raft's first
  std::vector<BeadSize> beads_;
  Plan plan_;
  std::vector<geom::Regions> bare_;  ///< by layer: what walls and gap lines leave unprinted
  std::vector<double> dense_mm2_;
};

}  // namespace

SampledPlan build_samples(const slice::LayerStack& cuts, const std::vector<LayerGroup>& groups,
                          const PrintSettings& settings, const run::Context& ctx) {
  if (groups.empty()) return {};
  return Builder(cuts, groups, settings, ctx).run();
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

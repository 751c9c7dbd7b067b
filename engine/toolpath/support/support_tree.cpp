#include "engine/toolpath/support/support_tree.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_columns.h"
#include "engine/toolpath/support/tree_grow.h"
#include "engine/toolpath/support/tree_room.h"

#include <algorithm>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

constexpr int kSides = 24;
/// Roofs are simplified to this, mm.
constexpr double kRoofToleranceMm = 0.05;
/// Roofs smaller than this hold nothing, mm².
constexpr double kMinRoofMm2 = 0.5;
/// Branches thinner than this are not printed, in line widths.
constexpr double kMinBranchWidths = 0.9;
/// Sections thinner than this are left to their neighbours above and below, mm of radius.
constexpr double kMinRadiusMm = 0.1;
/// A column below a branch is wider than that by this, mm, on each side.
constexpr double kColumnMarginMm = 0.6;
/// Dense lines go over from one tip to the next if what is between them is no wider than twice this share of
/// the tips' distance...
constexpr double kRoofSpanShare = 0.6;
/// ...and on beyond the last one by this share of it.
constexpr double kRoofBeyondShare = 0.5;
constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;

/// The contact's part that has room in all layers from `low` up to its own.
Regions roof_of(const SupportTask& task, std::size_t contact, std::size_t low, const SliceSettings& s) {
  Regions out = geom::simplify(task.contact[contact], from_mm(kRoofToleranceMm));
  for (std::size_t k = contact + 1; k-- > low;)
    if (k == contact || task.forbidden[k] != task.forbidden[k + 1])
      out = quick_subtract(out, task.forbidden[k]);
  return geom::remove_small(geom::open(out, from_mm(0.5 * s.line_width_mm)), kMinRoofMm2 * kMm2);
}

Regions outline_of(const std::vector<BranchSection>& sections) {
  geom::Rings discs;
  for (const auto& section : sections)
    if (section.radius_mm >= kMinRadiusMm)
      discs.push_back(geom::make_circle(section.centre, from_mm(section.radius_mm), kSides));
  return geom::unite(discs);
}

/// Those of the areas in layer i that lie on nothing.
Regions unfounded(const Regions& areas, std::size_t i, const std::vector<SupportAreas>& trees,
                  const slice::LayerStack& stack, const SliceSettings& s) {
  Regions out;
  if (i == 0 || areas.empty()) return out;
  const Regions below = geom::offset(printed_area(trees[i - 1]), from_mm(kCarriedShare * s.line_width_mm));
  const std::size_t rest = layer_below_gap(stack, i, s.support_z_gap_mm);
  for (const auto& area : areas) {
    if (!quick_intersect({area}, below).empty()) continue;
    if (rest < stack.size() && !quick_intersect({area}, stack[rest].regions).empty()) continue;
    out.push_back(area);
  }
  return out;
}

/// Branches that begin in the air, because a way that was wide enough for their middle was too narrow for
/// them: what is to carry them, by layer, large enough for a column.
std::vector<Regions> floating(const std::vector<SupportAreas>& trees, const slice::LayerStack& stack,
                              const SliceSettings& s, const run::Context& ctx) {
  std::vector<Regions> out(trees.size());
  run::parallel_for(ctx, trees.size(), [&](std::size_t i) {
    const Regions air = unfounded(trees[i].branches, i, trees, stack, s);
    if (!air.empty()) out[i - 1] = geom::offset(air, from_mm(kColumnMarginMm));
  });
  return out;
}

/// Dense lines in layer i, as far as what lies below bears them.
Regions borne(const Regions& roof, std::size_t i, const std::vector<SupportAreas>& trees,
              const slice::LayerStack& stack, const SliceSettings& s) {
  const double between = kRoofSpanShare * s.tree_tip_distance_mm;
  const double beyond = kRoofBeyondShare * s.tree_tip_distance_mm;
  Regions held = geom::offset(geom::close(printed_area(trees[i - 1]), from_mm(between), geom::Join::round),
                              from_mm(beyond), geom::Join::round);
  const std::size_t rest = layer_below_gap(stack, i, s.support_z_gap_mm);
  if (s.support == SupportMode::everywhere && rest < stack.size())
    held = quick_unite(held, geom::offset(quick_intersect(roof, stack[rest].regions),
                                          from_mm(kCarriedShare * s.line_width_mm)));
  const Regions out = quick_intersect(roof, held);
  return geom::remove_small(geom::open(out, from_mm(0.5 * s.line_width_mm)), kMinRoofMm2 * kMm2);
}

/// From the plate up, leaves out what still begins in the air, and so all that stands on that alone.
void drop_unfounded(std::vector<SupportAreas>& trees, const slice::LayerStack& stack, const SliceSettings& s,
                    const run::Context& ctx) {
  for (std::size_t i = 1; i < trees.size(); ++i) {
    ctx.check();
    const Regions air = unfounded(trees[i].branches, i, trees, stack, s);
    if (!air.empty()) trees[i].branches = quick_subtract(trees[i].branches, air);
    Regions& roof = trees[i].interface;
    if (!roof.empty() && roof != trees[i - 1].interface) roof = borne(roof, i, trees, stack, s);
  }
}

}  // namespace

std::vector<SupportAreas> support_trees(const slice::LayerStack& stack, const SupportTask& task,
                                        const SliceSettings& settings, const run::Context& ctx) {
  const std::size_t n = stack.size();
  std::vector<SupportAreas> out(n);
  const auto roofs = static_cast<std::size_t>(std::max(settings.support_interface_layers, 0));
  std::size_t top = n;
  while (top > 0 && task.contact[top - 1].empty()) --top;
  if (top == 0) return out;

  // A roof lies in `roofs` layers from its contact down, and what holds it begins below.
  std::vector<Regions> roof(top);
  run::parallel_for(ctx, top, [&](std::size_t c) {
    if (!task.contact[c].empty())
      roof[c] = roof_of(task, c, c + 1 > roofs ? c + 1 - std::max<std::size_t>(roofs, 1) : 0, settings);
  });
  std::vector<Regions> held(top);
  for (std::size_t c = roofs; c < top; ++c) held[c - roofs] = roof[c];
  const TreeRoom room(stack, task, top - 1, settings, ctx);
  Branches branches = grow_branches(held, stack, room, settings, ctx);

  run::parallel_for(ctx, top, [&](std::size_t i) {
    SupportAreas& areas = out[i];
    for (std::size_t c = i; c < std::min(top, i + roofs); ++c)
      areas.interface = quick_unite(areas.interface, roof[c]);
    areas.interface = quick_subtract(areas.interface, task.forbidden[i]);
    areas.branches = quick_subtract(outline_of(branches.sections[i]), task.forbidden[i]);
    // What is left of a branch beside a roof may be a sliver.
    areas.branches = geom::open(quick_subtract(areas.branches, areas.interface),
                                from_mm(0.5 * kMinBranchWidths * settings.line_width_mm));
  });

  SupportTask rest;
  rest.contact = floating(out, stack, settings, ctx);
  for (std::size_t i = 0; i < top; ++i) append(rest.contact[i + roofs], Regions(branches.unheld[i]));
  if (std::all_of(rest.contact.begin(), rest.contact.end(), [](const Regions& r) { return r.empty(); }))
    return out;
  rest.forbidden = task.forbidden;
  const std::vector<SupportAreas> columns = support_columns(stack, rest, settings, ctx);
  run::parallel_for(ctx, top, [&](std::size_t i) {
    out[i].interface = quick_unite(out[i].interface, columns[i].interface);
    out[i].branches = quick_subtract(out[i].branches, columns[i].interface);
    const Regions rest_of_tree = quick_unite(out[i].interface, out[i].branches);
    out[i].sparse = quick_subtract(columns[i].sparse, rest_of_tree);
    out[i].floor = quick_subtract(columns[i].floor, rest_of_tree);
    out[i].lattice = columns[i].lattice;
    out[i].caps = columns[i].caps;
    if (!rest_of_tree.empty()) out[i].caps = geom::clip_outside(out[i].caps, rest_of_tree);
    out[i].bordered = quick_subtract(columns[i].bordered, rest_of_tree);
  });
  drop_unfounded(out, stack, settings, ctx);
  return out;
}

}  // namespace voidpath::toolpath

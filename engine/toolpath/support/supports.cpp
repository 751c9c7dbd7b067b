#include "engine/toolpath/support/supports.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_columns.h"
#include "engine/toolpath/support/support_task.h"
#include "engine/toolpath/support/support_tree.h"

#include <algorithm>
#include <utility>

namespace voidpath::toolpath {

using geom::from_mm;
using geom::Regions;

namespace {

/// A contact reaches this far beyond what it is to hold, or a little further, and support holds what is
/// beside it by about as much, mm.
constexpr double kBeyondOverhangMm = 0.75;
/// What reaches out no further than this from the layer below is carried along by it, mm.
constexpr double kCarriedAlongMm = 0.9;
/// Areas smaller than this that begin in the air are no ground for what is above them, mm²: points of struts.
constexpr double kSmallIslandMm2 = 0.1;
/// Less than this so far out is noise of offsets, mm².
constexpr double kMinFarMm2 = 0.02;

/// Layer i without the small areas that begin in it: those carry nothing along, but hang themselves.
Regions carrying(const slice::LayerStack& stack, std::size_t i) {
  Regions out = stack[i].regions;
  if (i > 0)
    std::erase_if(out, [&](const geom::Region& r) {
      return geom::area(r) < kSmallIslandMm2 * geom::kNmPerMm * geom::kNmPerMm &&
             quick_intersect({r}, stack[i - 1].regions).empty();
    });
  return out;
}

/// Of the layers that a contact in layer c holds: what reaches far out beyond the layer below.
Regions far_out(const slice::LayerStack& stack, std::size_t c, const SliceSettings& s) {
  Regions out;
  for (std::size_t k = c + 1; k < stack.size(); ++k) {
    const std::size_t bearer = layer_below_gap(stack, k, s.support_z_gap_mm);
    if (bearer == stack.size() || bearer < c) continue;
    if (bearer > c) break;
    out = quick_unite(out, quick_subtract(stack[k].regions,
                                          geom::offset(carrying(stack, k - 1), from_mm(kCarriedAlongMm))));
  }
  return geom::remove_small(out, kMinFarMm2 * geom::kNmPerMm * geom::kNmPerMm);
}

/// What reaches far out and no column holds: there was none that could stand.
SupportTask without_column(const slice::LayerStack& stack, const SupportTask& task,
                           const std::vector<SupportAreas>& columns, const SliceSettings& s,
                           const run::Context& ctx) {
  SupportTask out;
  out.contact.resize(task.contact.size());
  run::parallel_for(ctx, task.contact.size(), [&](std::size_t i) {
    if (task.contact[i].empty()) return;
    const Regions left = quick_subtract(task.contact[i], printed_area(columns[i]));
    Regions bare = geom::offset(left, -from_mm(kBeyondOverhangMm));
    if (bare.empty()) return;
    const Regions far = far_out(stack, i, s);
    std::erase_if(bare, [&](const geom::Region& r) { return quick_intersect({r}, far).empty(); });
    if (!bare.empty())
      out.contact[i] = quick_intersect(geom::offset(bare, from_mm(kBeyondOverhangMm)), task.contact[i]);
  });
  if (std::all_of(out.contact.begin(), out.contact.end(), [](const Regions& r) { return r.empty(); }))
    return {};
  out.forbidden = task.forbidden;
  return out;
}

/// Columns where they can stand; branches, which lean out around the part, to what is left.
std::vector<SupportAreas> columns_and_branches(const slice::LayerStack& stack, const SupportTask& task,
                                               const SliceSettings& settings, const run::Context& ctx) {
  std::vector<SupportAreas> out = support_columns(stack, task, settings, ctx);
  if (settings.support != SupportMode::everywhere) return out;
  const SupportTask rest = without_column(stack, task, out, settings, ctx);
  if (rest.empty()) return out;
  std::vector<SupportAreas> trees = support_trees(stack, rest, settings, ctx);
  run::parallel_for(ctx, out.size(), [&](std::size_t i) {
    SupportAreas& own = out[i];
    SupportAreas& tree = trees[i];
    const Regions column = printed_area(own);
    own.branches = quick_subtract(quick_unite(tree.branches, tree.sparse), column);
    own.interface = quick_unite(own.interface, quick_subtract(tree.interface, column));
    own.floor = quick_unite(own.floor, quick_subtract(tree.floor, column));
  });
  return out;
}

}  // namespace

Regions printed_area(const SupportAreas& areas) {
  return quick_unite(quick_unite(quick_unite(areas.sparse, areas.interface), areas.branches), areas.floor);
}

std::vector<SupportAreas> find_supports(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces,
                                        const SliceSettings& settings, const run::Context& ctx) {
  std::vector<SupportAreas> none(stack.size());
  if (settings.support == SupportMode::none || stack.empty()) return none;
  const SupportTask task = find_support_task(stack, surfaces, settings, ctx);
  if (task.empty()) return none;
  return settings.support_style == SupportStyle::tree ? support_trees(stack, task, settings, ctx)
                                                      : columns_and_branches(stack, task, settings, ctx);
}

}  // namespace voidpath::toolpath

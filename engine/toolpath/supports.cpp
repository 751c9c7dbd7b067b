#include "engine/toolpath/supports.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support_columns.h"
#include "engine/toolpath/support_task.h"
#include "engine/toolpath/support_tree.h"

namespace voidpath::toolpath {

using geom::Regions;

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
                                                      : support_columns(stack, task, settings, ctx);
}

}  // namespace voidpath::toolpath

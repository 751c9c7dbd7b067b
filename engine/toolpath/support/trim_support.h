#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// From the plate up, the support's lines without what nothing carries: an end that sticks out over air, a
/// stretch between two held places that is longer than lines are apart, a line that lies on nothing at all.
/// Pressed into the air they would hold nothing, and hang where the nozzle passes next.
/// Carried is what lies on support one layer down, beside it as far as it may lean, between its lines, or on
/// the part the z gap below. `lines`: of each layer of the stack, straight strands in any order.
void trim_support(std::vector<std::vector<Path>*>& lines, const slice::LayerStack& stack,
                  const SliceSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

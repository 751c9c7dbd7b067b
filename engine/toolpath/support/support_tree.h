#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/support_task.h"
#include "engine/toolpath/support/supports.h"

#include <vector>

namespace voidpath::toolpath {

/// A dense roof of the interface layers under every contact, held by the tips of branches, which lean
/// towards one another on their way down, become one and grow thicker, keep away from the part and end on
/// the plate, or on the part where they may and cannot get past it. What no branch can reach is held by
/// columns.
///
/// Room is known before a branch grows: from the plate up, for each layer, the places from which a branch of
/// a tip's width would strike the part sooner or later, however it leans. A branch never enters them, so
/// none has to be taken back.
std::vector<SupportAreas> support_trees(const slice::LayerStack& stack, const SupportTask& task,
                                        const SliceSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

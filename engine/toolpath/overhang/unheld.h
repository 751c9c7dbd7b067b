#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/supports.h"

#include <vector>

namespace voidpath::toolpath {

/// What hangs without hold at both ends was left to the supports. Where none of them has come, for want of
/// room or of a place to stand, it is printed as a bridge after all: slowly, as strands, with the fan on.
void bridge_unheld(std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
                   const std::vector<SupportAreas>& supports, const SliceSettings& settings,
                   const run::Context& ctx);

}  // namespace voidpath::toolpath

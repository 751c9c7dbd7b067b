#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// Takes out of every layer's solid area what spans the gaps of sparse infill in the layer below, with its
/// anchors: it is printed as a bridge. Over a hollow it gets the direction in which it finds hold soonest
/// (anchored); over infill it stays without: its lines cross the infill's. Dense infill has no gaps worth it.
void find_internal_bridges(std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
                           const SliceSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

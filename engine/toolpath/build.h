#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

namespace voidpath::toolpath {

/// From the part's cuts to ordered extrusion paths: perimeters, top and bottom skins found by comparing
/// layers, bridges, sparse infill, supports, skirt and brim. The stack is in plate coordinates already
/// (see place_on_bed). Deterministic, whatever the number of threads. Throws run::Stopped.
Plan build(const slice::LayerStack& stack, const PrintSettings& settings, const run::Context& ctx = {});

/// Moves a part that is centred on (0, 0) to the middle of the bed.
void place_on_bed(slice::LayerStack& stack, const MachineShape& machine);

}  // namespace voidpath::toolpath

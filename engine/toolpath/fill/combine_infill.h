#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// Layers whose sparse infill is printed together, [first, first + count).
struct InfillGroup {
  std::size_t first = 0;
  std::size_t count = 1;
};

/// The stack from the second layer on in groups of up to infill_every_layers, none of them thicker than the
/// nozzle is wide.
std::vector<InfillGroup> infill_groups(const slice::LayerStack& stack, const PrintSettings& settings);

/// Moves the sparse area that all layers of a group share to the group's last layer, as Surfaces::thick.
/// Lightning's lines differ from layer to layer and stay as they are.
void combine_infill(std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
                    const PrintSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// Half the distance of lines at the settings' density, mm: no point that lightning holds is further from a
/// line than this.
double lightning_reach_mm(const SliceSettings& settings);

/// Sparse infill only where something lies on it: trees rooted at the border of each layer's sparse area,
/// that hold what is printed solid above within lightning_reach_mm(). From the layers that hold, downwards,
/// their branches grow shorter by 45° and straighter until they have gone into the walls (after Tricard,
/// Claux and Lefebvre 2019, "Ribbed support vaults for 3D printing of hollowed objects"). Lines by layer.
std::vector<geom::Polylines> lightning_lines(const std::vector<Surfaces>& surfaces,
                                             const slice::LayerStack& stack, const SliceSettings& settings,
                                             const run::Context& ctx);

}  // namespace voidpath::toolpath

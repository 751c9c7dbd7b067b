#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <span>
#include <vector>

namespace voidpath::toolpath {

/// Gap lines up to `widest_mm` whose free end hangs over air are cut back to where they are held: a thread
/// that is pressed into the air holds to nothing and ends up somewhere else. A tip may stick out; the layers
/// above go on from it. `ground`: what carries lines. Returns the area that stays without them.
geom::Regions cut_threads(std::vector<Path>& paths, const geom::Regions& ground, double widest_mm);

/// The same for every layer of the stack: what was cut from one carries nothing of the next, nor does what
/// is `bare` already; what was cut is added to it. Lines much thinner than asked for are cut at any rate;
/// wider ones only if there is to be support, which holds whatever hangs far.
void cut_threads(std::span<LayerPlan> layers, const slice::LayerStack& stack,
                 std::vector<geom::Regions>& bare, const SliceSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

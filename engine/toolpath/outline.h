#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"

/// From the part's cuts to the outlines that are printed.
namespace voidpath::toolpath {

/// At the resolution asked, with the compensations of the settings; the first layer less its elephant foot.
slice::LayerStack outlines(const slice::LayerStack& cuts, const SliceSettings& settings,
                           const run::Context& ctx);

/// Outer contours grow by `outer_mm`, holes widen by `hole_mm`; both may be negative.
geom::Regions compensated(const geom::Regions& regions, double outer_mm, double hole_mm);

/// Shrinks by `by_mm`, for a layer that the plate squeezes wide. What would then be thinner than a line of
/// `width_mm` keeps its width: it sticks as it is or not at all.
geom::Regions without_foot(const geom::Regions& regions, double by_mm, double width_mm);

}  // namespace voidpath::toolpath

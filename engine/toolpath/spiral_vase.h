#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

namespace voidpath::toolpath {

/// The bottom layers as any print has them (one at least), then a single wall along the outer contour that
/// climbs all the way, without seam, travel or retraction. Each round begins on the contour below and ends on
/// its own, so that contours pass into one another without a step. The first round begins with no thickness
/// and grows, one at the end levels the rim.
///
/// Layers with several separate contours cannot be climbed: they print as closed loops, and the spiral begins
/// anew above them. What is too narrow for a wall that goes there and back, a fin or a whole sheet, is one line
/// down its middle, level, after the round. Holes, top layers, infill and supports are left out.
Plan build_vase(const slice::LayerStack& cuts, const PrintSettings& settings, const run::Context& ctx);

/// The wall's contours in one layer: centre lines.
geom::Rings vase_contours(const geom::Regions& outline, double line_width_mm);

/// One round: from the point `begin`, on the contour below, once around `ring` to where `end` is on it.
/// `below` may be empty; then the round keeps to `ring`.
geom::Polyline vase_round(const geom::Ring& ring, const geom::Ring& below, const geom::Point& end,
                          const geom::Point& begin);

}  // namespace voidpath::toolpath

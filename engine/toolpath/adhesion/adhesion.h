#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/walls/perimeters.h"

namespace voidpath::toolpath {

/// Closed loops at the settings' distance around the convex hull of what they surround, from outside inwards.
geom::Rings skirt_loops(const geom::Regions& around, const SliceSettings& settings, const BeadSize& bead);

/// Convex hull, counter-clockwise (Andrew's monotone chain).
geom::Ring convex_hull(std::vector<geom::Point> points);

}  // namespace voidpath::toolpath

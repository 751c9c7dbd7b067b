#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/perimeters.h"
#include "engine/toolpath/settings.h"

namespace voidpath::toolpath {

/// Closed loops around the outer borders of `footprint`, from outside inwards; none inside holes.
geom::Rings brim_loops(const geom::Regions& footprint, const SliceSettings& settings, const BeadSize& bead);

/// Closed loops around the convex hull of everything on the first layer, from outside inwards.
geom::Rings skirt_loops(const geom::Regions& footprint, const SliceSettings& settings, const BeadSize& bead);

/// Convex hull, counter-clockwise (Andrew's monotone chain).
geom::Ring convex_hull(std::vector<geom::Point> points);

}  // namespace voidpath::toolpath

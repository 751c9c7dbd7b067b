#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// Strands across a bridge, `apart_mm` from one another. `domain` holds their middles, `ground` what carries
/// them. A strand that would begin or end in the air goes on to the ground beside it, or to the end of another
/// strand, where one is near and the way there is inside the domain, or leaves it by `beyond_mm` at most: what
/// is pressed out into the air holds to nothing.
geom::Polylines bridge_lines(const geom::Region& domain, const geom::Regions& ground, double angle_rad,
                             double apart_mm, double beyond_mm);

}  // namespace voidpath::toolpath

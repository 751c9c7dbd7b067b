#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// How far strands may leave their domain to find ground, mm, and how far they must where they find none so
/// near: below a thin wall's roof there is none but under the outer wall.
struct BridgeReach {
  double beyond_mm = 0;
  double at_most_mm = 0;
};

/// Strands across a bridge, `apart_mm` from one another. `domain` holds their middles, `ground` what carries
/// them. A strand that would begin or end in the air goes on to the ground beside it, or to the end of
/// another strand, where one is near and the way there is inside the domain, or leaves it by `reach` at most:
/// what is pressed out into the air holds to nothing.
geom::Polylines bridge_lines(const geom::Region& domain, const geom::Regions& ground, double angle_rad,
                             double apart_mm, const BridgeReach& reach);

}  // namespace voidpath::toolpath

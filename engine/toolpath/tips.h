#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"

#include <vector>

namespace voidpath::toolpath {

/// Cuts gap lines that run out into the air to what the bead before carries: a long tip would only curl up.
/// `own` and `below`: the outlines of this layer and of the one underneath. `support`: what holds from a gap
/// below.
void trim_tips(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
               const geom::Regions& support, double width_mm);

}  // namespace voidpath::toolpath

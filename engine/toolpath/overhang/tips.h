#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"

#include <vector>

namespace voidpath::toolpath {

/// Gap lines that stop in the air just before ground go on to it: their ends keep inside the area that they
/// fill, and may hold on to nothing there. What is too thin below to have been printed is no ground for an
/// end whose line is held further on.
/// `own` and `below`: the outlines of this layer and of the one underneath. `support`: what holds from a gap
/// below.
void hold_tips(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
               const geom::Regions& support);

}  // namespace voidpath::toolpath

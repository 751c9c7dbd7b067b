#pragma once

#include "engine/toolpath/fill/infill.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/walls/perimeters.h"

#include <vector>

namespace voidpath::toolpath {

Path make_path(Role role, geom::Polyline points, bool closed, double width_mm, double height_mm,
               double area_mm2);

/// Turns lines into beads that share out the area's volume, simplified to the tolerance.
void add_fill(std::vector<Path>& out, Role role, FillLines&& fill, const BeadSize& bead, double tolerance_mm);

}  // namespace voidpath::toolpath

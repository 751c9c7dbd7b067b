#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// What beads this wide cover along the lines, their round ends as half squares: nearly as far as they go.
geom::Regions bead_area(const geom::Polylines& lines, double width_nm);

}  // namespace voidpath::toolpath

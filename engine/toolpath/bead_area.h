#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// What beads this wide cover along the lines, their round ends as half squares: nearly as far as they go.
geom::Regions bead_area(const geom::Polylines& lines, double width_nm);

/// Adds what one line covers, piece by piece, to rings that are then united.
void add_beads(geom::Rings& quads, const geom::Polyline& line, double width_nm);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/geom/polygon.h"

namespace voidpath::toolpath {

/// The contour of a wall inside `outline`, half its width from it, counter-clockwise, but with sharp corners
/// further out: the bead's round end leaves the tip of the part bare there. The wall then lies up to 0.04 mm
/// over the outline beside such a corner, less and less along its flanks.
geom::Ring with_corners_out(const geom::Ring& ring, const geom::Region& outline, double width_mm);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/toolpath/fill/concentric_fill.h"

namespace voidpath::toolpath {

/// Connected Fermat spirals (Zhao et al. 2016, "Connected Fermat spirals for layered fabrication") over one
/// region of centre_line_area(): contours at equal distances from the border are joined to double spirals
/// where they lie in one another, and the spirals to one line that enters and leaves each of them from the
/// contour beside it. One line for each part of the region that is wide enough for beads to pass.
RingFill fermat_fill(const geom::Region& domain, const BeadSize& bead);

}  // namespace voidpath::toolpath

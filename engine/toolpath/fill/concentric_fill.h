#pragma once

#include "engine/toolpath/fill/infill.h"
#include "engine/toolpath/walls/perimeters.h"

namespace voidpath::toolpath {

/// Lines that follow the border, and the slivers they leave where the area's width is no multiple of theirs.
struct RingFill {
  FillLines lines;
  geom::Regions gaps;
};

/// Loops in one another, the outermost along the border of this region of centre_line_area().
RingFill concentric_fill(const geom::Region& domain, const BeadSize& bead);

/// The area whose outermost loop runs along the domain's border, for make_perimeters().
geom::Regions around_centre_lines(const geom::Region& domain, const BeadSize& bead);

}  // namespace voidpath::toolpath

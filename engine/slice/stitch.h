#pragma once

#include "engine/geom/polygon.h"
#include "engine/slice/section.h"

/// Segments to rings. Frame: plate, nm. Winding: material left of every line.
///
/// Along sound parts of a mesh the walk from facet to facet (section.h) has already made rings. What is
/// left are lines that end where the mesh is open or where neighbours disagree on which side is out.
/// They are joined in this order, nearest first, ties by position in the list:
///   1. an end to a start no farther than `gap` (cracks: vertices that should be one);
///   2. an end to an end or a start to a start no farther than `gap`, turning the shorter line (facets
///      that look the wrong way);
///   3. an end to a start at any distance, by the shortest gap, but first those whose joint crosses no
///      line of the section (holes in the surface).
namespace voidpath::slice {

/// All contours as closed rings; fewer than three distinct points are no ring.
geom::Rings stitch(Contours&& contours, geom::Coord gap);

}  // namespace voidpath::slice

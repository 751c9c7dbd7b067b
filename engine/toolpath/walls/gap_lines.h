#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/walls/perimeters.h"

#include <cstddef>
#include <vector>

namespace voidpath::toolpath {

/// Thinner than this, as a share of the line width, nothing is printed.
inline constexpr double kMinGapWidth = 0.25;

/// Lines down the middle of slivers between beads, as wide as the sliver is there: a line is cut where its
/// width changes, each piece with the mean width of its stretch. Ends keep inside; what fills the first
/// `at_outline` slivers keeps inside `outline`, that of the part, all along.
void add_gap_lines(std::vector<Path>& out, const geom::Regions& gaps, const BeadSize& bead,
                   double tolerance_mm, const geom::Region* outline = nullptr, std::size_t at_outline = 0);
/// The same for areas that stand alone: whatever is too thin for a gap line gets the thinnest one, what is
/// too short a dot.
void add_thin_lines(std::vector<Path>& out, const geom::Regions& areas, const BeadSize& bead,
                    double tolerance_mm);

}  // namespace voidpath::toolpath

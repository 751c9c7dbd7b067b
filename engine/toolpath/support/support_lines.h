#pragma once

#include "engine/toolpath/plan.h"
#include "engine/toolpath/support/supports.h"
#include "engine/toolpath/walls/perimeters.h"

#include <vector>

namespace voidpath::toolpath {

/// The lines of one layer's support. Where a column is narrower than the
/// distance of its lines, its border is printed, so that every column stands and holds.
std::vector<Path> support_lines(const SupportAreas& areas, std::size_t layer, const BeadSize& bead,
                                const SliceSettings& settings);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/toolpath/draft.h"
#include "engine/toolpath/supports.h"

#include <vector>

namespace voidpath::toolpath {

/// The lines of one layer's support, an island for each connected area. Where a column is narrower than the
/// distance of its lines, its border is printed, so that every column stands and holds.
std::vector<IslandDraft> support_lines(const SupportAreas& areas, std::size_t layer, const BeadSize& bead,
                                       const SliceSettings& settings);

}  // namespace voidpath::toolpath

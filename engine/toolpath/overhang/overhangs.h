#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// Cuts external and inner perimeters where they hang over air, as far as `below` (the outline of the layer
/// underneath, of which `bare` was not printed) does not carry them: stretches of whose bead a quarter, a
/// half or three quarters hang are slowed to the speeds set for it; what has less than a quarter of its bead
/// on the layer below becomes overhang_perimeter. Order and direction stay.
void mark_overhangs(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
                    const geom::Regions& bare, double width_mm, const SpeedSettings& speed);

}  // namespace voidpath::toolpath

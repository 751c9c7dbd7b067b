#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"

#include <optional>
#include <vector>

namespace voidpath::toolpath {

/// Where skins were left to the supports, solid lines that lie neither on the layer below, within `lean_mm`,
/// nor as near to a printed line of support as it holds what is beside it: those stretches are bridges. A
/// column's last line may lie short of its border, or have been trimmed. `unheld`: what was left to them;
/// `bearer`: the paths of the layer whose support is to hold. The layer's paths with such stretches cut out
/// of their lines; nothing where there are none.
std::optional<std::vector<Path>> bridge_hanging_fill(const std::vector<Path>& paths,
                                                     const geom::Regions& unheld, const geom::Regions& below,
                                                     const std::vector<Path>& bearer, double lean_mm);

}  // namespace voidpath::toolpath

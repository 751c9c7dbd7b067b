#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/draft.h"
#include "engine/toolpath/plan.h"

#include <vector>

namespace voidpath::toolpath {

/// What a layer's paths leave bare of what the walls have no room in: the point of a spike, a web between two
/// holes, for which a line of its own would be too short or too thin, and the tips of acute corners of
/// `outline`, which the round bead of a wall does not reach. It carries nothing.
geom::Regions bare_parts(const LayerWalls& walls, const std::vector<Path>& paths,
                         const geom::Regions& outline);

}  // namespace voidpath::toolpath

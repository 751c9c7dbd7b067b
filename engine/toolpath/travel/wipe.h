#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"

namespace voidpath::toolpath {

/// Where the nozzle moves after `path` to leave what it oozes on the path itself: back over an open path, on
/// along a closed one, or back where that leads nearer to `next`. Begins at the path's end; at most
/// `length_mm` long, shorter where the path is.
geom::Polyline wipe_way(const Path& path, const geom::Point& next, double length_mm);

}  // namespace voidpath::toolpath

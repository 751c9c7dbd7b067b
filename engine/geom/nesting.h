#pragma once

#include "engine/geom/polygon_ops.h"

#include <optional>

namespace voidpath::geom {

/// The regions that the rings fill, when no two edges of theirs touch but neighbours in their common
/// corner: then it is enough to find which ring lies in which, and points stay as they are. Nothing when
/// any do touch (or a ring repeats a point): then only a clipper can tell.
/// O(n log n) for evenly spread edges.
std::optional<Regions> nest_if_disjoint(const Rings& rings, FillRule rule);

/// Whether two edges of the rings touch other than neighbours in their common corner.
bool any_edges_touch(const Rings& rings);

}  // namespace voidpath::geom

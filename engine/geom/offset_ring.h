#pragma once

#include "engine/geom/polygon_ops.h"

#include <optional>

namespace voidpath::geom {

struct OffsetStyle {
  Join join = Join::miter;
  double miter_limit = 2.0;
  double arc_tolerance_nm = 0;
};

/// The ring moved by delta nm to its right (outwards where it runs counter-clockwise). Corners that open
/// are joined in the given style, corners that close become the crossing of their two moved edges.
/// Nothing when an edge vanishes on the way or a corner cannot be told: then only a clipper can tell
/// what remains. The result may still cross itself; where it does not, it is the true offset.
std::optional<Ring> offset_ring(const Ring& ring, Coord delta, const OffsetStyle& style);

}  // namespace voidpath::geom

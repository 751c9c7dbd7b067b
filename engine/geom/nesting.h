#pragma once

#include "engine/geom/polygon.h"

#include <optional>
#include <vector>

namespace voidpath::geom {

/// A ring of a border: counter-clockwise around what it fills, clockwise around a hole. Rings do not cross;
/// they may meet in corners.
struct TracedRing {
  Ring ring;
  Point probe;  ///< a corner that no other ring has
  bool has_probe = false;
};

/// Outer rings, each with its holes: a hole goes into the smallest outer ring around it. Rings that hold no
/// area are left out. Nothing where a hole has no probe, or no ring around it.
std::optional<Regions> nest(std::vector<TracedRing>&& rings);

/// Without the corners that lie on the straight line between their neighbours.
void drop_straight(Ring& ring);

}  // namespace voidpath::geom

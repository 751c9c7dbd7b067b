#pragma once

#include "engine/geom/polygon.h"

#include <vector>

namespace voidpath::toolpath {

/// A stretch of a line that is carried or not.
struct Stretch {
  geom::Polyline points;
  bool held = false;
};

/// The pieces of a line that are carried, joined over the stretches that hang between two held places and are
/// no longer than `span_mm`; at its ends it may hang by `tip_mm`. Of a closed line each piece begins and ends
/// where it is carried.
geom::Polylines held_pieces(std::vector<Stretch>&& stretches, bool closed, double tip_mm, double span_mm);

}  // namespace voidpath::toolpath

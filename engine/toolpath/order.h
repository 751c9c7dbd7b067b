#pragma once

#include "engine/geom/polygon.h"

#include <cstddef>
#include <vector>

namespace voidpath::toolpath {

/// Something printed in one go: entered at one end, left at the other.
struct Stop {
  geom::Point in;
  geom::Point out;
  bool reversible = false;  ///< may be entered at `out` as well
};

struct Visit {
  std::size_t index = 0;
  bool reversed = false;
};

/// An order of all stops that keeps the travel between them short, starting from `from`: nearest neighbour,
/// then 2-opt and Or-opt while they pay, within limits of effort. Depends on the input alone.
std::vector<Visit> order_stops(const std::vector<Stop>& stops, const geom::Point& from);

}  // namespace voidpath::toolpath

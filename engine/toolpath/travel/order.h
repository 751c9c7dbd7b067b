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
  /// A loop may be entered, and is then left, at any of these; `in` and `out` are one of them.
  std::vector<geom::Point> entries = {};
};

/// A loop's stop: up to kLoopEntries of its vertices, evenly spread.
inline constexpr std::size_t kLoopEntries = 24;
Stop loop_stop(const geom::Ring& loop);

struct Visit {
  std::size_t index = 0;
  bool reversed = false;
  geom::Point in = {};  ///< where it is entered
};

/// An order of all stops that keeps the travel between them short, starting from `from`: a generalised
/// travelling salesman's tour. Nearest neighbour and, where there are not too many, nearest insertion; each
/// improved by 2-opt and Or-opt while they pay, within limits of effort; then the best entry and direction of
/// every stop for that order, by dynamic programming, and once more from there. The shorter tour is taken.
/// Depends on the input alone.
std::vector<Visit> order_stops(const std::vector<Stop>& stops, const geom::Point& from);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/geom/polygon.h"

#include <algorithm>

namespace voidpath::toolpath {

/// A direction in the plane, of length 1; nought between equal points.
struct Way {
  double x = 0, y = 0;
};

inline Way way(const geom::Point& from, const geom::Point& to) {
  const double d = std::max(geom::distance(from, to), 1.0);
  return {static_cast<double>(to.x - from.x) / d, static_cast<double>(to.y - from.y) / d};
}

}  // namespace voidpath::toolpath

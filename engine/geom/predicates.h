#pragma once

#include "engine/geom/polygon.h"

/// Exact signs on integer nanometres.
namespace voidpath::geom {

/// Holds any product of two coordinate differences, and sums of many of them.
__extension__ typedef __int128 Wide;

constexpr Wide cross(const Point& u, const Point& v) {
  return static_cast<Wide>(u.x) * v.y - static_cast<Wide>(u.y) * v.x;
}

constexpr int sign(Wide v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

/// +1 when c lies left of the line from a to b, -1 right of it, 0 on it.
constexpr int orientation(const Point& a, const Point& b, const Point& c) {
  return sign(cross({b.x - a.x, b.y - a.y}, {c.x - a.x, c.y - a.y}));
}

constexpr bool overlap(const Box& a, const Box& b) {
  return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y;
}

}  // namespace voidpath::geom

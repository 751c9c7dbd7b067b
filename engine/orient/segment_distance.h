#pragma once

#include "engine/orient/cross_section.h"

#include <algorithm>

namespace voidpath::orient {

/// Squared distance of a point to a segment. mm²
inline double to_segment2(Point2 p, Point2 a, Point2 b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  const double t = length2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
  const double x = a.x + t * dx - p.x;
  const double y = a.y + t * dy - p.y;
  return x * x + y * y;
}

/// Squared distance of two segments that do not cross: one of their ends is nearest.
inline double segments2(Point2 a, Point2 b, Point2 c, Point2 d) {
  return std::min(std::min(to_segment2(a, c, d), to_segment2(b, c, d)),
                  std::min(to_segment2(c, a, b), to_segment2(d, a, b)));
}

}  // namespace voidpath::orient

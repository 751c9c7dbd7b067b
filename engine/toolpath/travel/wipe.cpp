#include "engine/toolpath/travel/wipe.h"

#include <cmath>

namespace voidpath::toolpath {

namespace {

/// From point `at` on in steps of `step` through `count` points, cut off after `length` nm.
geom::Polyline stretch(const geom::Polyline& points, std::size_t at, bool forward, std::size_t count,
                       double length) {
  const std::size_t n = points.size();
  geom::Polyline out{points[at]};
  for (std::size_t k = 0; k < count && length > 0; ++k) {
    at = (forward ? at + 1 : at + n - 1) % n;
    const geom::Point from = out.back(), to = points[at];
    const double d = geom::distance(from, to);
    if (d <= 0) continue;
    if (d <= length) {
      out.push_back(to);
    } else {
      const double t = length / d;
      out.push_back({from.x + std::llround(t * static_cast<double>(to.x - from.x)),
                     from.y + std::llround(t * static_cast<double>(to.y - from.y))});
    }
    length -= d;
  }
  return out;
}

}  // namespace

geom::Polyline wipe_way(const Path& path, const geom::Point& next, double length_mm) {
  const std::size_t n = path.points.size();
  const double length = length_mm * geom::kNmPerMm;
  if (n < 2 || length <= 0) return {};
  if (!path.closed) return stretch(path.points, n - 1, false, n - 1, length);
  geom::Polyline on = stretch(path.points, 0, true, n, length);
  geom::Polyline back = stretch(path.points, 0, false, n, length);
  return geom::distance(back.back(), next) < geom::distance(on.back(), next) ? back : on;
}

}  // namespace voidpath::toolpath

#include "engine/geom/polygon_ops.h"

#include <algorithm>

namespace voidpath::geom {

namespace {

/// Squared distance of p to the segment from a to b, nm².
double distance_squared(const Point& p, const Point& a, const Point& b) {
  const auto dx = static_cast<double>(b.x - a.x);
  const auto dy = static_cast<double>(b.y - a.y);
  const auto px = static_cast<double>(p.x - a.x);
  const auto py = static_cast<double>(p.y - a.y);
  const double len2 = dx * dx + dy * dy;
  const double t = len2 > 0 ? std::clamp((px * dx + py * dy) / len2, 0.0, 1.0) : 0.0;
  const double ex = px - t * dx;
  const double ey = py - t * dy;
  return ex * ex + ey * ey;
}

/// Douglas and Peucker 1973 on points[first..last]: the points kept between the two ends are marked.
void mark_kept(const std::vector<Point>& points, std::size_t first, std::size_t last, double tolerance2,
               std::vector<char>& keep) {
  std::vector<std::pair<std::size_t, std::size_t>> todo{{first, last}};
  while (!todo.empty()) {
    const auto [a, b] = todo.back();
    todo.pop_back();
    double worst = tolerance2;
    std::size_t at = 0;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double d = distance_squared(points[i], points[a], points[b]);
      if (d > worst) {
        worst = d;
        at = i;
      }
    }
    if (at == 0) continue;
    keep[at] = 1;
    todo.emplace_back(a, at);
    todo.emplace_back(at, b);
  }
}

/// The ring is cut at its lowest-leftmost corner and at the corner farthest from it: both lie on the
/// hull, so the result does not depend on where the ring starts.
Ring simplified(const Ring& ring, double tolerance2) {
  if (ring.size() < 4) return ring;
  Ring turned = ring;
  std::rotate(turned.begin(), std::min_element(turned.begin(), turned.end()), turned.end());
  const auto far = std::max_element(turned.begin(), turned.end(), [&](const Point& a, const Point& b) {
    return distance(turned.front(), a) < distance(turned.front(), b);
  });
  const auto split = static_cast<std::size_t>(far - turned.begin());
  const std::size_t n = turned.size();
  turned.push_back(turned.front());
  std::vector<char> keep(n + 1, 0);
  keep[0] = keep[split] = 1;
  mark_kept(turned, 0, split, tolerance2, keep);
  mark_kept(turned, split, n, tolerance2, keep);
  Ring out;
  for (std::size_t i = 0; i < n; ++i)
    if (keep[i]) out.push_back(turned[i]);
  return out;
}

}  // namespace

Regions simplify(const Regions& regions, Coord tolerance) {
  if (tolerance <= 0) return regions;
  const double tolerance2 = static_cast<double>(tolerance) * static_cast<double>(tolerance);
  Rings rings;
  bool changed = false;
  for (const Region& r : regions) {
    auto take = [&](const Ring& ring) {
      Ring s = simplified(ring, tolerance2);
      changed |= s.size() != ring.size();
      if (s.size() >= 3) rings.push_back(std::move(s));
    };
    take(r.outer);
    for (const Ring& hole : r.holes) take(hole);
  }
  // Shortcuts of neighbouring rings may cross; positive winding puts that right.
  return changed ? unite(rings, FillRule::positive) : regions;
}

Polyline simplify(const Polyline& line, Coord tolerance) {
  if (line.size() < 3 || tolerance <= 0) return line;
  std::vector<char> keep(line.size(), 0);
  keep.front() = keep.back() = 1;
  mark_kept(line, 0, line.size() - 1, static_cast<double>(tolerance) * static_cast<double>(tolerance), keep);
  Polyline out;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (keep[i]) out.push_back(line[i]);
  return out;
}

}  // namespace voidpath::geom

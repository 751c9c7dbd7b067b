#include "engine/geom/polygon.h"

#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>

namespace voidpath::geom {

namespace {

enum class Side { outside, border, inside };

Side locate(const Ring& ring, const Point& p) {
  bool inside = false;
  if (ring.empty()) return Side::outside;
  Point a = ring.back();
  for (const Point& b : ring) {
    if (p == b) return Side::border;
    if (a.y == p.y && b.y == p.y) {
      if ((a.x <= p.x) != (b.x < p.x)) return Side::border;
    } else if ((a.y <= p.y) != (b.y <= p.y)) {
      const int turn = orientation(a, b, p);
      if (turn == 0) return Side::border;
      if ((turn > 0) == (b.y > a.y)) inside = !inside;
    }
    a = b;
  }
  return inside ? Side::inside : Side::outside;
}

void extend(std::optional<Box>& box, const Ring& ring) {
  for (const Point& p : ring) {
    if (!box) {
      box = Box{p, p};
      continue;
    }
    box->min = {std::min(box->min.x, p.x), std::min(box->min.y, p.y)};
    box->max = {std::max(box->max.x, p.x), std::max(box->max.y, p.y)};
  }
}

}  // namespace

double area(const Ring& ring) {
  if (ring.size() < 3) return 0;
  // Summed exactly about a corner: slivers keep their sign.
  const Point o = ring.front();
  Wide twice = 0;
  for (std::size_t i = 1; i + 1 < ring.size(); ++i)
    twice += cross({ring[i].x - o.x, ring[i].y - o.y}, {ring[i + 1].x - o.x, ring[i + 1].y - o.y});
  return static_cast<double>(twice) / 2;
}

double area(const Region& region) {
  double sum = area(region.outer);
  for (const Ring& hole : region.holes) sum += area(hole);
  return sum;
}

double area(const Regions& regions) {
  double sum = 0;
  for (const Region& r : regions) sum += area(r);
  return sum;
}

double length(const Polyline& line) {
  double sum = 0;
  for (std::size_t i = 1; i < line.size(); ++i) sum += distance(line[i - 1], line[i]);
  return sum;
}

double perimeter(const Ring& ring) {
  return ring.empty() ? 0 : length(ring) + distance(ring.back(), ring.front());
}

std::optional<Box> bounds(const Ring& ring) {
  std::optional<Box> box;
  extend(box, ring);
  return box;
}

std::optional<Box> bounds(const Regions& regions) {
  std::optional<Box> box;
  for (const Region& r : regions) extend(box, r.outer);
  return box;
}

bool contains(const Ring& ring, const Point& p) { return locate(ring, p) != Side::outside; }

bool contains(const Region& region, const Point& p) {
  if (locate(region.outer, p) == Side::outside) return false;
  return std::none_of(region.holes.begin(), region.holes.end(),
                      [&](const Ring& hole) { return locate(hole, p) == Side::inside; });
}

void reverse(Ring& ring) { std::reverse(ring.begin(), ring.end()); }

void translate(Regions& regions, Point by) {
  auto move = [by](Ring& ring) {
    for (Point& p : ring) p = {p.x + by.x, p.y + by.y};
  };
  for (Region& r : regions) {
    move(r.outer);
    for (Ring& hole : r.holes) move(hole);
  }
}

Rings rings_of(const Regions& regions) {
  Rings rings;
  for (const Region& r : regions) {
    rings.push_back(r.outer);
    rings.insert(rings.end(), r.holes.begin(), r.holes.end());
  }
  return rings;
}

}  // namespace voidpath::geom

#pragma once

#include "engine/geom/units.h"

#include <cmath>
#include <optional>
#include <vector>

namespace voidpath::geom {

struct Point {
  Coord x = 0;
  Coord y = 0;
  friend bool operator==(const Point&, const Point&) = default;
  friend auto operator<=>(const Point&, const Point&) = default;
};

/// Closed: the last point is joined to the first, which is not repeated. Outer rings run
/// counter-clockwise (positive area), holes clockwise.
using Ring = std::vector<Point>;
using Rings = std::vector<Ring>;
/// Open line.
using Polyline = std::vector<Point>;
using Polylines = std::vector<Polyline>;

/// A connected filled area: one outer ring less its direct holes. Islands in a hole are regions of
/// their own.
struct Region {
  Ring outer;
  Rings holes;
  friend bool operator==(const Region&, const Region&) = default;
};
using Regions = std::vector<Region>;

struct Box {
  Point min;
  Point max;
  friend bool operator==(const Box&, const Box&) = default;
};

/// Signed, nm²; positive for counter-clockwise.
double area(const Ring& ring);
/// Filled area, nm².
double area(const Region& region);
double area(const Regions& regions);

/// nm.
double length(const Polyline& line);
double perimeter(const Ring& ring);
/// Coordinates are far too small for their squares to overflow: std::hypot would take five times as long.
inline double distance(const Point& a, const Point& b) {
  const auto x = static_cast<double>(b.x - a.x);
  const auto y = static_cast<double>(b.y - a.y);
  return std::sqrt(x * x + y * y);
}

/// Empty when there are no points.
std::optional<Box> bounds(const Ring& ring);
std::optional<Box> bounds(const Regions& regions);

/// Whether the point lies in the ring, its border included.
bool contains(const Ring& ring, const Point& p);
/// Whether the point lies in the filled area, its border included.
bool contains(const Region& region, const Point& p);

void reverse(Ring& ring);
void translate(Regions& regions, Point by);
/// All rings of the regions, outer ones and holes, in order.
Rings rings_of(const Regions& regions);

}  // namespace voidpath::geom

#include "engine/orient/hull2d.h"

#include "engine/orient/inner_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace voidpath::orient {

namespace {

/// What the extent may exceed the room by, for rounding. mm
constexpr double kFitNoise = 1e-6;

double cross(Point2 o, Point2 a, Point2 b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); }

/// Extent of the outline along the unit vector at `angle`, and the vector across its two extreme points.
struct Extent {
  double width;
  Point2 across;
};
Extent extent(const std::vector<Point2>& outline, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Extent e{0, {}};
  Point2 low = outline.front();
  Point2 high = outline.front();
  auto along = [&](Point2 p) { return c * p.x + s * p.y; };
  for (const Point2 p : outline) {
    if (along(p) < along(low)) low = p;
    if (along(p) > along(high)) high = p;
  }
  e.across = {high.x - low.x, high.y - low.y};
  e.width = along(high) - along(low);
  return e;
}

/// Turning the outline by +turn measures it along the axes turned by -turn.
bool fits_at(const std::vector<Point2>& outline, double turn, double x, double y) {
  return extent(outline, -turn).width <= x + kFitNoise &&
         extent(outline, std::numbers::pi / 2 - turn).width <= y + kFitNoise;
}

}  // namespace

std::vector<Point2> convex_outline(std::vector<Point2>& points) {
  drop_inner(points, [](Point2 p) { return p; });
  std::sort(points.begin(), points.end(),
            [](Point2 a, Point2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  points.erase(
      std::unique(points.begin(), points.end(), [](Point2 a, Point2 b) { return a.x == b.x && a.y == b.y; }),
      points.end());
  if (points.size() < 3) return points;
  std::vector<Point2> out(2 * points.size());
  std::size_t n = 0;
  for (const Point2 p : points) {
    while (n >= 2 && cross(out[n - 2], out[n - 1], p) <= 0) --n;
    out[n++] = p;
  }
  const std::size_t lower = n + 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) {
    while (n >= lower && cross(out[n - 2], out[n - 1], points[i]) <= 0) --n;
    out[n++] = points[i];
  }
  out.resize(n - 1);
  return out;
}

double depth_inside(const std::vector<Point2>& outline, Point2 p) {
  if (outline.empty()) return -std::numeric_limits<double>::infinity();
  double inside = std::numeric_limits<double>::infinity();
  double outside = std::numeric_limits<double>::infinity();
  bool is_in = outline.size() >= 3;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point2 a = outline[i];
    const Point2 b = outline[(i + 1) % outline.size()];
    const double dx = b.x - a.x;
    const double dy = b.y - a.y;
    const double length2 = dx * dx + dy * dy;
    const double t =
        length2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
    outside = std::min(outside, std::hypot(a.x + t * dx - p.x, a.y + t * dy - p.y));
    if (cross(a, b, p) < 0) is_in = false;
    if (length2 > 0) inside = std::min(inside, cross(a, b, p) / std::sqrt(length2));
  }
  return is_in ? inside : -outside;
}

Rectangle smallest_rectangle(const std::vector<Point2>& outline) {
  const std::size_t n = outline.size();
  if (n < 2) return {};
  // Rotating calipers (Toussaint 1983): as the edge moves on, so do the corners furthest along it, across it
  // and against it.
  std::size_t front = 0;
  std::size_t far = 0;
  std::size_t back = 0;
  Rectangle best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 a = outline[i];
    const Point2 b = outline[(i + 1) % n];
    const double length = std::hypot(b.x - a.x, b.y - a.y);
    if (!(length > 0)) continue;
    const double ux = (b.x - a.x) / length;
    const double uy = (b.y - a.y) / length;
    auto along = [&](std::size_t k) { return ux * outline[k % n].x + uy * outline[k % n].y; };
    auto across = [&](std::size_t k) { return ux * outline[k % n].y - uy * outline[k % n].x; };
    front = std::max(front, i + 1);
    while (front < i + n && along(front + 1) >= along(front)) ++front;
    far = std::max(far, front);
    while (far < i + n && across(far + 1) >= across(far)) ++far;
    back = std::max(back, far);
    while (back < i + n && along(back + 1) <= along(back)) ++back;
    const Rectangle r{along(front) - along(back), across(far) - across(i)};
    if (r.area() < least) {
      least = r.area();
      best = r;
    }
  }
  if (best.x < best.y) std::swap(best.x, best.y);
  return best;
}

std::optional<double> turn_to_fit(const std::vector<Point2>& outline, double x, double y) {
  if (outline.empty() || fits_at(outline, 0, x, y)) return 0.0;
  constexpr double kHalfTurn = std::numbers::pi;
  std::vector<double> turns{0};
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Point2 a = outline[i];
    const Point2 b = outline[(i + 1) % outline.size()];
    const double angle = std::atan2(b.y - a.y, b.x - a.x);
    for (const double turn : {-angle, kHalfTurn / 2 - angle}) {
      const double t = std::fmod(turn, kHalfTurn);
      turns.push_back(t < 0 ? t + kHalfTurn : t);
    }
  }
  std::sort(turns.begin(), turns.end());
  turns.push_back(kHalfTurn);
  std::optional<double> best;
  auto offer = [&](double turn) {
    if (turn > kHalfTurn / 2) turn -= kHalfTurn;
    if ((!best || std::abs(turn) < std::abs(*best)) && fits_at(outline, turn, x, y)) best = turn;
  };
  // Within an interval the same two corners are extreme along each axis, so an extent is r·cos(turn - phase):
  // what fits begins at an end of the interval or where an extent equals the room.
  for (std::size_t i = 0; i + 1 < turns.size(); ++i) {
    offer(turns[i]);
    const double middle = 0.5 * (turns[i] + turns[i + 1]);
    for (const auto& [axis, room] : {std::pair(0.0, x), std::pair(kHalfTurn / 2, y)}) {
      const Point2 r = extent(outline, axis - middle).across;
      const double length = std::hypot(r.x, r.y);
      if (!(length > room)) continue;
      // across · (cos(axis - turn), sin(axis - turn)) = room
      const double phase = std::atan2(r.y, r.x);
      const double half = std::acos(room / length);
      for (const double turn : {axis - phase - half, axis - phase + half})
        for (const double shift : {-2 * kHalfTurn, 0.0, 2 * kHalfTurn}) {
          const double t = turn + shift;
          if (t >= turns[i] && t <= turns[i + 1]) offer(t);
        }
    }
  }
  return best;
}

}  // namespace voidpath::orient

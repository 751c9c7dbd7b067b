#include "engine/orient/hull_distance.h"

#include "engine/orient/inner_points.h"
#include "engine/orient/segment_distance.h"

#include <algorithm>
#include <cmath>

namespace voidpath::orient {

namespace {

/// The search ends when no corner lies nearer by more than this share of the squared distance.
constexpr double kGain = 1e-13;
/// Hulls of a few hundred corners take ten steps; more than this is rounding going in circles.
constexpr int kMostSteps = 64;
/// A ring that leaves the straight line by less is straight: below the noise of single-precision files. mm
constexpr double kFlat = 1e-6;

double cross(Point2 o, Point2 a, Point2 b) { return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x); }

/// A number that grows with the angle of (x, y), in [0, 16): which of the table's directions is nearest
/// below.
std::size_t sector(double x, double y) {
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  const double sum = ax + ay;
  if (!(sum > 0)) return 0;
  // Within a quadrant y / (x + y) grows from 0 to 1.
  const double r = (x >= 0) == (y >= 0) ? ay / sum : ax / sum;
  const double quadrant = y >= 0 ? (x >= 0 ? 0 : 1) : (x < 0 ? 2 : 3);
  return std::min<std::size_t>(static_cast<std::size_t>(4 * (quadrant + r)), 15);
}

/// The direction in the middle of a sector.
Point2 direction_of(std::size_t s) {
  const double r = (static_cast<double>(s % 4) + 0.5) / 4;
  const Point2 first{1 - r, r};
  switch (s / 4) {
    case 0:
      return first;
    case 1:
      return {-first.y, first.x};
    case 2:
      return {-first.x, -first.y};
    default:
      return {first.y, -first.x};
  }
}

}  // namespace

void HullDistance::clear() {
  hulls_.clear();
  corners_.clear();
}

std::size_t HullDistance::add(const std::vector<Point2>& points, std::size_t begin, std::size_t end) {
  sorted_.clear();
  for (std::size_t i = begin; i < end; ++i)
    sorted_.push_back({points[i], static_cast<std::uint32_t>(i - begin), false});
  drop_inner(sorted_, [](const Corner& c) { return c.p; });
  std::sort(sorted_.begin(), sorted_.end(), [](const Corner& a, const Corner& b) {
    if (a.p.x != b.p.x) return a.p.x < b.p.x;
    return a.p.y != b.p.y ? a.p.y < b.p.y : a.place < b.place;
  });
  Hull h{static_cast<std::uint32_t>(corners_.size()), 0, static_cast<std::uint32_t>(end - begin), {}};
  // Lower chain, then upper chain (Andrew 1979).
  const std::size_t base = corners_.size();
  auto push = [&](const Corner& c, std::size_t floor) {
    while (corners_.size() >= floor + 2 &&
           cross(corners_[corners_.size() - 2].p, corners_.back().p, c.p) <= 0)
      corners_.pop_back();
    corners_.push_back(c);
  };
  for (const Corner& c : sorted_) push(c, base);
  const std::size_t turn = corners_.size() - 1;
  for (std::size_t i = sorted_.size() - 1; i-- > 0;) push(sorted_[i], turn);
  if (corners_.size() > base + 1) corners_.pop_back();  // the first again
  h.size = static_cast<std::uint32_t>(corners_.size() - base);
  // Turning through the directions, the furthest corner only moves on.
  std::uint32_t at = 0;
  const Point2 first = direction_of(0);
  for (std::uint32_t i = 1; i < h.size; ++i)
    if (first.x * corner(h, i).p.x + first.y * corner(h, i).p.y >
        first.x * corner(h, at).p.x + first.y * corner(h, at).p.y)
      at = i;
  h.extreme[0] = at;
  for (std::size_t s = 1; s < kDirections; ++s) {
    const Point2 d = direction_of(s);
    for (std::uint32_t steps = 0; steps < h.size; ++steps) {
      const std::uint32_t next = at + 1 == h.size ? 0 : at + 1;
      const Point2 p = corner(h, at).p;
      const Point2 q = corner(h, next).p;
      if (d.x * (q.x - p.x) + d.y * (q.y - p.y) <= 0) break;
      at = next;
    }
    h.extreme[s] = at;
  }
  // A ring's hull takes its corners in the order the ring runs, counter-clockwise or clockwise.
  double twice = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const Point2 q = points[i + 1 == end ? begin : i + 1];
    twice += (points[i].x - points[begin].x) * (q.y - points[begin].y) -
             (q.x - points[begin].x) * (points[i].y - points[begin].y);
  }
  for (std::uint32_t i = 0; i < h.size; ++i)
    corners_[h.begin + i].straight = runs_straight(h, i, points, begin, twice > 0);
  hulls_.push_back(h);
  return hulls_.size() - 1;
}

std::uint32_t HullDistance::support(const Hull& h, double dx, double dy) const {
  std::uint32_t best = h.extreme[sector(dx, dy)];
  auto along = [&](std::uint32_t i) { return dx * corner(h, i).p.x + dy * corner(h, i).p.y; };
  double most = along(best);
  for (const bool onward : {true, false}) {
    for (std::uint32_t steps = 0; steps < h.size; ++steps) {
      const std::uint32_t next =
          onward ? (best + 1 == h.size ? 0 : best + 1) : (best == 0 ? h.size - 1 : best - 1);
      const double v = along(next);
      if (v <= most) break;
      best = next;
      most = v;
    }
  }
  return best;
}

/// Whether the ring runs straight from hull corner i to the next: corners of the ring in between lie on the
/// line, as they do where a slice crosses the many facets of a flat face.
bool HullDistance::runs_straight(const Hull& h, std::uint32_t i, const std::vector<Point2>& points,
                                 std::size_t begin, bool ccw) const {
  const Corner& from = corner(h, i);
  const Corner& to = corner(h, i + 1 == h.size ? 0 : i + 1);
  const std::uint32_t n = h.ring_size;
  for (std::uint32_t k = from.place;;) {
    k = ccw ? (k + 1 == n ? 0 : k + 1) : (k == 0 ? n - 1 : k - 1);
    if (k == to.place) return true;
    if (to_segment2(points[begin + k], from.p, to.p) > kFlat * kFlat) return false;
  }
}

bool HullDistance::is_ring_edge(const Hull& h, std::uint32_t a, std::uint32_t b) const {
  if (b == (a + 1 == h.size ? 0 : a + 1)) return corner(h, a).straight;
  return a == (b + 1 == h.size ? 0 : b + 1) && corner(h, b).straight;
}

HullDistance::Answer HullDistance::between(std::size_t first, std::size_t second) const {
  const Hull& a = hulls_[first];
  const Hull& b = hulls_[second];
  // The simplex holds one or two corners of the difference b - a; v is its point nearest to the origin.
  struct Vertex {
    std::uint32_t a, b;
    Point2 p;
  };
  auto vertex = [&](std::uint32_t i, std::uint32_t j) {
    const Point2 p = corner(a, i).p;
    const Point2 q = corner(b, j).p;
    return Vertex{i, j, {q.x - p.x, q.y - p.y}};
  };
  Vertex s[2] = {vertex(0, 0), {}};
  int n = 1;
  Point2 v = s[0].p;
  for (int step = 0; step < kMostSteps; ++step) {
    const double v2 = v.x * v.x + v.y * v.y;
    if (!(v2 > 0)) return {};
    const Vertex w = vertex(support(a, v.x, v.y), support(b, -v.x, -v.y));
    if (v2 - (v.x * w.p.x + v.y * w.p.y) <= kGain * v2) {
      const bool edge_a = n == 2 && s[0].a != s[1].a;
      const bool edge_b = n == 2 && s[0].b != s[1].b;
      if ((edge_a && !is_ring_edge(a, s[0].a, s[1].a)) || (edge_b && !is_ring_edge(b, s[0].b, s[1].b)))
        return {};
      const Point2 a0 = corner(a, s[0].a).p;
      const Point2 b0 = corner(b, s[0].b).p;
      const Point2 a1 = n == 2 ? corner(a, s[1].a).p : a0;
      const Point2 b1 = n == 2 ? corner(b, s[1].b).p : b0;
      const double d2 = edge_a && edge_b ? segments2(a0, a1, b0, b1)
                        : edge_a         ? to_segment2(b0, a0, a1)
                                         : to_segment2(a0, b0, b1);
      return {std::sqrt(d2), true};
    }
    if (n == 2) {
      // Beyond the segment seen from the origin, or the origin lies within: then the hulls overlap.
      const double side = cross(s[0].p, s[1].p, w.p);
      const double origin = cross(s[0].p, s[1].p, {0, 0});
      const double c0 = cross(s[1].p, w.p, {0, 0});
      const double c1 = cross(w.p, s[0].p, {0, 0});
      if ((origin >= 0) == (side >= 0) && (c0 >= 0) == (side >= 0) && (c1 >= 0) == (side >= 0)) return {};
    }
    // Nearest of the segments from the new corner to the old ones; the old segment itself cannot be nearer.
    double least = 0;
    Vertex best[2] = {w, w};
    int best_n = 0;
    Point2 best_v;
    for (int k = 0; k < n; ++k) {
      const double dx = w.p.x - s[k].p.x;
      const double dy = w.p.y - s[k].p.y;
      const double l2 = dx * dx + dy * dy;
      const double t = l2 > 0 ? -(s[k].p.x * dx + s[k].p.y * dy) / l2 : 1.0;
      Point2 q;
      if (t >= 1) {
        q = w.p;
      } else if (t <= 0) {
        q = s[k].p;
      } else {
        q = {s[k].p.x + t * dx, s[k].p.y + t * dy};
      }
      const double q2 = q.x * q.x + q.y * q.y;
      if (best_n == 0 || q2 < least) {
        least = q2;
        best_v = q;
        best_n = t > 0 && t < 1 ? 2 : 1;
        best[0] = t >= 1 ? w : s[k];
        best[1] = w;
      }
    }
    if (!(least < v2)) return {};  // no progress but by rounding
    n = best_n;
    s[0] = best[0];
    s[1] = best[1];
    v = best_v;
  }
  return {};
}

}  // namespace voidpath::orient

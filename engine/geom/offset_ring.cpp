#include "engine/geom/offset_ring.h"

#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::geom {

namespace {

struct Direction {
  double x = 0;
  double y = 0;
};

/// Sine of a turn below which a corner counts as straight: the joint then misses by less than 1 nm at
/// any offset used in printing.
constexpr double kStraightSine = 1e-9;
/// A moved edge shorter than this, nm, counts as vanished: rounding could have turned it.
constexpr double kShortestEdgeNm = 4;

class RingOffset {
 public:
  RingOffset(const Ring& ring, Coord delta, const OffsetStyle& style)
      : ring_(ring), delta_(static_cast<double>(delta)), style_(style) {
    const double reach = std::abs(delta_);
    if (style.join == Join::round && reach > style.arc_tolerance_nm)
      step_rad_ = 2 * std::acos(1 - style.arc_tolerance_nm / reach);
  }

  std::optional<Ring> run() {
    const std::size_t n = ring_.size();
    if (n < 3 || !find_directions()) return std::nullopt;
    Ring out;
    out.reserve(n + 8);
    // Where each moved edge starts and ends.
    Point first_start;
    Point start;
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t before = out.size();
      if (!add_corner(i, out)) return std::nullopt;
      // The edge that ends in this corner runs from `start` to the corner's first point.
      if (i == 0)
        first_start = out[before];
      else if (!keeps_direction(start, out[before], directions_[i - 1]))
        return std::nullopt;
      start = out.back();
    }
    if (!keeps_direction(start, first_start, directions_[n - 1])) return std::nullopt;
    return out;
  }

 private:
  bool find_directions() {
    const std::size_t n = ring_.size();
    directions_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Point& a = ring_[i];
      const Point& b = ring_[(i + 1) % n];
      const auto dx = static_cast<double>(b.x - a.x);
      const auto dy = static_cast<double>(b.y - a.y);
      const double length = std::sqrt(dx * dx + dy * dy);
      if (length == 0) return false;
      directions_[i] = {dx / length, dy / length};
    }
    return true;
  }

  static bool keeps_direction(const Point& a, const Point& b, const Direction& d) {
    return static_cast<double>(b.x - a.x) * d.x + static_cast<double>(b.y - a.y) * d.y >= kShortestEdgeNm;
  }

  /// The corner moved along (x, y), in units of delta.
  Point moved(const Point& p, double x, double y) const {
    return {p.x + std::llround(delta_ * x), p.y + std::llround(delta_ * y)};
  }

  /// The points that replace corner i, between edges u and v. Right of a direction (x, y) is (y, -x).
  bool add_corner(std::size_t i, Ring& out) const {
    const Point& p = ring_[i];
    const Direction& u = directions_[i == 0 ? ring_.size() - 1 : i - 1];
    const Direction& v = directions_[i];
    const double sine = u.x * v.y - u.y * v.x;
    const double cosine = u.x * v.x + u.y * v.y;
    if (std::abs(sine) < kStraightSine) {
      if (cosine < 0) return false;
      out.push_back(moved(p, v.y, -v.x));
      return true;
    }
    const bool opens = (sine > 0) == (delta_ > 0);
    // |u's normal + v's normal|² / 2: the miter is sqrt(2 / (1 + cosine)) deltas long.
    if (!opens ||
        (style_.join == Join::miter && 2 <= style_.miter_limit * style_.miter_limit * (1 + cosine))) {
      if (1 + cosine < kStraightSine) return false;
      out.push_back(moved(p, (u.y + v.y) / (1 + cosine), -(u.x + v.x) / (1 + cosine)));
      return true;
    }
    const double turn = std::atan2(sine, cosine);
    if (style_.join == Join::round) {
      add_arc(p, u, turn, out);
    } else {
      // Cut off square at one delta from the corner, across the bisector.
      const double t = std::tan(turn / 4);
      out.push_back(moved(p, u.y + t * u.x, -u.x + t * u.y));
      out.push_back(moved(p, v.y - t * v.x, -v.x - t * v.y));
    }
    return true;
  }

  void add_arc(const Point& p, const Direction& u, double turn, Ring& out) const {
    const auto steps = static_cast<int>(std::max(1.0, std::ceil(std::abs(turn) / step_rad_)));
    for (int k = 0; k <= steps; ++k) {
      const double a = turn * k / steps;
      const double x = std::cos(a) * u.x - std::sin(a) * u.y;
      const double y = std::sin(a) * u.x + std::cos(a) * u.y;
      const Point q = moved(p, y, -x);
      if (k == 0 || q != out.back()) out.push_back(q);
    }
  }

  const Ring& ring_;
  double delta_;
  OffsetStyle style_;
  double step_rad_ = std::numbers::pi;
  std::vector<Direction> directions_;
};

}  // namespace

std::optional<Ring> offset_ring(const Ring& ring, Coord delta, const OffsetStyle& style) {
  return RingOffset(ring, delta, style).run();
}

}  // namespace voidpath::geom

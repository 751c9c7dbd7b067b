#include "engine/geom/offset_ring.h"

#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
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

  Ring run() {
    const std::size_t n = ring_.size();
    if (n < 3 || !find_directions()) return {};
    const std::vector<char> trimmed = find_trimmed();
    Ring out;
    out.reserve(2 * n);
    for (std::size_t i = 0; i < n; ++i)
      if (trimmed[i] == 0 || !add_corner(i, out)) add_spike(i, out);
    return out;
  }

 private:
  const Direction& before(std::size_t i) const { return directions_[i == 0 ? ring_.size() - 1 : i - 1]; }

  /// Corners that close and whose two moved edges both are long enough to be cut where they cross. All that
  /// open as well.
  std::vector<char> find_trimmed() const {
    const std::size_t n = ring_.size();
    std::vector<double> trim(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      const Direction &u = before(i), &v = directions_[i];
      const double sine = u.x * v.y - u.y * v.x, cosine = u.x * v.x + u.y * v.y;
      if ((sine > 0) != (delta_ > 0))
        trim[i] = 1 + cosine < kStraightSine ? std::numeric_limits<double>::infinity()
                                             : std::abs(delta_ * sine) / (1 + cosine);
    }
    std::vector<char> out(n, 1);
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t k = (i + 1) % n;
      const double room = std::max(distance(ring_[i], ring_[k]) - kShortestEdgeNm, 0.0);
      if (trim[i] + trim[k] <= room) continue;
      // Of two that share an edge, one at least wants more than half.
      if (trim[i] > room / 2) out[i] = 0;
      if (trim[k] > room / 2) out[k] = 0;
    }
    return out;
  }

  /// Out to the end of the one moved edge, back to the corner, out to the start of the other.
  void add_spike(std::size_t i, Ring& out) const {
    const Direction &u = before(i), &v = directions_[i];
    out.push_back(moved(ring_[i], u.y, -u.x));
    out.push_back(ring_[i]);
    out.push_back(moved(ring_[i], v.y, -v.x));
  }

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

  /// The corner moved along (x, y), in units of delta.
  Point moved(const Point& p, double x, double y) const {
    return {p.x + std::llround(delta_ * x), p.y + std::llround(delta_ * y)};
  }

  /// The points that replace corner i, between edges u and v. Right of a direction (x, y) is (y, -x).
  bool add_corner(std::size_t i, Ring& out) const {
    const Point& p = ring_[i];
    const Direction& u = before(i);
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

Ring raw_offset_ring(const Ring& ring, Coord delta, const OffsetStyle& style) {
  Ring clean;
  clean.reserve(ring.size());
  std::unique_copy(ring.begin(), ring.end(), std::back_inserter(clean));
  while (clean.size() > 1 && clean.front() == clean.back()) clean.pop_back();
  return RingOffset(clean, delta, style).run();
}

}  // namespace voidpath::geom

#include "engine/toolpath/walls/sharp_corners.h"

#include "engine/toolpath/walls/border.h"
#include "engine/toolpath/way.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace voidpath::toolpath {

namespace {

using geom::Point;
using geom::Ring;

/// The wall comes closer to the outline than half its width at corners sharper than this.
constexpr double kSharpDeg = 90;
/// So much closer, nm: less than what is printed may be off by anyhow.
constexpr double kOver = 40'000;
/// Further than this from the corner nothing moves, nm...
constexpr double kFlank = 1'000'000;
/// ...nor does the corner by more than this, nm: what is that sharp is not the wall's to fill.
constexpr double kMostOut = 250'000;

/// Steps in which a corner is tried, nm.
constexpr double kTry = 20'000;

/// Of points to whole nm, which flanks' distances add up.
constexpr double kRoundingMm = 1e-5;

class Contour {
 public:
  Contour(const Ring& ring, const geom::Region& outline, double width_mm)
      : ring_(ring), outline_(outline), least_mm_(0.5 * width_mm - kOver / geom::kNmPerMm) {
    at_.reserve(ring.size() + 1);
    at_.push_back(0);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      at_.push_back(at_.back() + geom::distance(ring[i], next(i)));
      if (const Way u = back(i), v = on(i); u.x * v.y > u.y * v.x && u.x * v.x + u.y * v.y < kStraightOn)
        sharp_.push_back(at_[i]);
    }
  }

  Ring moved() const {
    if (sharp_.empty()) return ring_;
    const Border border({outline_});
    std::vector<double> ends = flank_ends();
    Ring out;
    auto end = ends.begin();
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      out.push_back(moved(i, border));
      for (; end != ends.end() && *end < at_[i + 1]; ++end)
        if (*end > at_[i]) out.push_back(along(i, *end - at_[i]));
    }
    return out;
  }

 private:
  /// Cosine of the turn at a corner that is just sharp.
  static inline const double kStraightOn = -std::cos(kSharpDeg / 180 * std::numbers::pi) - 1e-6;

  const Point& next(std::size_t i) const { return ring_[(i + 1) % ring_.size()]; }
  Way back(std::size_t i) const { return way(ring_[(i + ring_.size() - 1) % ring_.size()], ring_[i]); }
  Way on(std::size_t i) const { return way(ring_[i], next(i)); }

  Point along(std::size_t i, double by) const {
    const Way v = on(i);
    return {ring_[i].x + std::llround(by * v.x), ring_[i].y + std::llround(by * v.y)};
  }

  /// Where flanks end, from the ring's first point on.
  std::vector<double> flank_ends() const {
    std::vector<double> out;
    for (const double s : sharp_)
      for (const double end : {s - kFlank, s + kFlank}) {
        const double around = std::fmod(end + at_.back(), at_.back());
        if (around >= 0 && distance_to_sharp(around) >= kFlank - 1) out.push_back(around);
      }
    std::sort(out.begin(), out.end());
    return out;
  }

  /// Along the ring.
  double distance_to_sharp(double at) const {
    double best = at_.back();
    for (const double s : sharp_) {
      const double d = std::abs(at - s);
      best = std::min({best, d, at_.back() - d});
    }
    return best;
  }

  /// A corner, away from the mean of its two flanks; a sharp one so far that either flank moves by kOver, as
  /// far as the part has a tip there.
  Point moved(std::size_t i, const Border& border) const {
    const double from_sharp = distance_to_sharp(at_[i]);
    if (from_sharp >= kFlank) return ring_[i];
    const Way u = back(i), v = on(i);
    const double x = u.y + v.y, y = -u.x - v.x;  // to the right of both: outside
    const double length = std::hypot(x, y);      // twice the sine of half the corner's angle
    if (length < 1e-9) return ring_[i];
    const auto at = [&](double out) {
      return Point{ring_[i].x + std::llround(out * x / length), ring_[i].y + std::llround(out * y / length)};
    };
    const double flanks = kOver * (1 - from_sharp / kFlank);
    for (double out = std::min(2 * flanks / length, kMostOut); out > flanks; out -= kTry)
      if (border.distance_mm(at(out), least_mm_) >= least_mm_ - kRoundingMm) return at(out);
    return at(flanks);
  }

  const Ring& ring_;
  const geom::Region& outline_;
  double least_mm_;            ///< from the outline
  std::vector<double> at_;     ///< way to each point, and around
  std::vector<double> sharp_;  ///< the same of sharp corners
};

}  // namespace

Ring with_corners_out(const Ring& ring, const geom::Region& outline, double width_mm) {
  return ring.size() < 3 ? ring : Contour(ring, outline, width_mm).moved();
}

}  // namespace voidpath::toolpath

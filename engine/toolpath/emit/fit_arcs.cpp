#include "engine/toolpath/emit/fit_arcs.h"

#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Fewer pieces are not worth an arc: its line is longer, and any two fit one.
constexpr std::size_t kLeastPieces = 3;
/// An arc goes round at most so far: nearer to a full turn its centre hangs on the last digit of its ends.
constexpr double kMostSweep = 1.75 * std::numbers::pi;
/// Flatter arcs are lines to any printer, and their centres lose digits, mm.
constexpr double kMostRadiusMm = 1000;
/// Sharper ones are corners, mm.
constexpr double kLeastRadiusMm = 0.1;

struct Circle {
  double x = 0, y = 0, r = 0;  ///< nm, relative to a point named where it is used
};

/// Through the origin and two points; nothing where they lie on a line or nearly.
std::optional<Circle> circle_through(double bx, double by, double cx, double cy) {
  const double d = 2 * (bx * cy - by * cx);
  const double b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
  Circle out;
  out.x = (cy * b2 - by * c2) / d;
  out.y = (bx * c2 - cx * b2) / d;
  out.r = std::hypot(out.x, out.y);
  if (!(out.r <= kMostRadiusMm * geom::kNmPerMm) || out.r < kLeastRadiusMm * geom::kNmPerMm)
    return std::nullopt;
  return out;
}

class Fitter {
 public:
  Fitter(const geom::Polyline& line, double tolerance) : line_(line), tolerance_(tolerance) {}

  std::vector<Stroke> run() {
    std::vector<Stroke> out;
    for (std::size_t i = 0; i + 1 < line_.size();) {
      const std::size_t last = furthest(i);
      if (last == i) {
        ++i;
        out.push_back({line_[i], i, 0, {}});
        continue;
      }
      out.push_back(*arc(i, last));
      i = last;
    }
    return out;
  }

 private:
  /// The last vertex to which one arc leads from vertex `i`; `i` itself if there is none. Doubles the step
  /// while it fits, then closes in: a few looks at each vertex.
  std::size_t furthest(std::size_t i) const {
    std::size_t good = kLeastPieces;
    if (!arc(i, i + good)) return i;
    std::size_t bad = 2 * good;
    for (; arc(i, i + bad); bad *= 2) good = bad;
    while (bad - good > 1) {
      const std::size_t mid = good + (bad - good) / 2;
      (arc(i, i + mid) ? good : bad) = mid;
    }
    return i + good;
  }

  std::optional<Stroke> arc(std::size_t from, std::size_t to) const {
    if (to >= line_.size()) return std::nullopt;
    const Point& o = line_[from];
    const Point& m = line_[from + (to - from) / 2];
    const Point& e = line_[to];
    const auto circle = circle_through(static_cast<double>(m.x - o.x), static_cast<double>(m.y - o.y),
                                       static_cast<double>(e.x - o.x), static_cast<double>(e.y - o.y));
    if (!circle) return std::nullopt;
    const int turn = geom::orientation(o, m, e);
    double sweep = 0;
    for (std::size_t k = from + 1; k <= to; ++k) {
      const double ax = static_cast<double>(line_[k - 1].x - o.x) - circle->x;
      const double ay = static_cast<double>(line_[k - 1].y - o.y) - circle->y;
      const double bx = static_cast<double>(line_[k].x - o.x) - circle->x;
      const double by = static_cast<double>(line_[k].y - o.y) - circle->y;
      if (std::abs(std::hypot(bx, by) - circle->r) > tolerance_) return std::nullopt;
      if (std::abs(std::hypot(0.5 * (ax + bx), 0.5 * (ay + by)) - circle->r) > tolerance_)
        return std::nullopt;
      const double angle = turn * std::atan2(ax * by - ay * bx, ax * bx + ay * by);
      if (!(angle > 0)) return std::nullopt;
      sweep += angle;
    }
    if (sweep > kMostSweep) return std::nullopt;
    return Stroke{e, to, turn, {o.x + std::llround(circle->x), o.y + std::llround(circle->y)}};
  }

  const geom::Polyline& line_;
  double tolerance_;
};

}  // namespace

std::vector<Stroke> fit_arcs(const geom::Polyline& line, double tolerance_mm) {
  return Fitter(line, tolerance_mm * geom::kNmPerMm).run();
}

}  // namespace voidpath::toolpath

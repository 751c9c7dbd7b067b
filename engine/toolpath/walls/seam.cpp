#include "engine/toolpath/walls/seam.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// How much longer a travel may get, mm, for a seam in a concave corner rather than a convex one, and in a
/// corner rather than on a smooth stretch: corners hide seams, concave ones best.
constexpr double kConvexPenaltyMm = 2.0;
constexpr double kSmoothPenaltyMm = 6.0;
/// A corner turns by at least this.
constexpr double kCornerRad = 35.0 * std::numbers::pi / 180.0;
/// An aligned seam pays this much per mm away from the seam below: staying outweighs a better corner that
/// is more than a millimetre off.
constexpr double kAlignWeight = 6.0;
/// A seam of the layer below further away than this belongs to another wall, mm.
constexpr double kAlignReachMm = 4.0;
/// Rear: corners may pull the seam this share of their worth forward.
constexpr double kRearCornerWeight = 0.15;

double distance_mm(const Point& a, const Point& b) { return geom::distance(a, b) / geom::kNmPerMm; }

/// Rings keep material on their left, so a right turn is a concave corner, for holes as well.
double corner_penalty(const geom::Ring& ring, std::size_t i) {
  const Point& p = ring[(i + ring.size() - 1) % ring.size()];
  const Point& q = ring[i];
  const Point& r = ring[(i + 1) % ring.size()];
  const auto ux = static_cast<double>(q.x - p.x);
  const auto uy = static_cast<double>(q.y - p.y);
  const auto vx = static_cast<double>(r.x - q.x);
  const auto vy = static_cast<double>(r.y - q.y);
  const double turn = std::atan2(ux * vy - uy * vx, ux * vx + uy * vy);
  if (turn < -kCornerRad) return 0;
  return turn > kCornerRad ? kConvexPenaltyMm : kSmoothPenaltyMm;
}

/// The seam below that is nearest to the loop, if any is within reach.
const Point* seam_below(const geom::Ring& loop, const std::vector<Point>& seams) {
  double best = kAlignReachMm;
  const Point* found = nullptr;
  for (const Point& s : seams) {
    const double d = distance_mm(loop[nearest_vertex(loop, s)], s);
    if (d < best) best = d, found = &s;
  }
  return found;
}

}  // namespace

std::size_t nearest_vertex(const geom::Ring& ring, const Point& p) {
  double best = std::numeric_limits<double>::max();
  std::size_t found = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const auto dx = static_cast<double>(ring[i].x - p.x);
    const auto dy = static_cast<double>(ring[i].y - p.y);
    if (dx * dx + dy * dy < best) best = dx * dx + dy * dy, found = i;
  }
  return found;
}

geom::Ring start_at(const geom::Ring& ring, std::size_t vertex) {
  geom::Ring out(ring);
  std::rotate(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(vertex), out.end());
  return out;
}

void SeamChooser::begin_layer() {
  previous_ = std::move(current_);
  current_.clear();
}

std::size_t SeamChooser::choose(const geom::Ring& loop, const Point& at) {
  const Point* below = position_ == SeamPosition::aligned ? seam_below(loop, previous_) : nullptr;
  double best = std::numeric_limits<double>::max();
  std::size_t found = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const double corner = corner_penalty(loop, i);
    double cost = corner;
    if (position_ == SeamPosition::rear)
      cost = kRearCornerWeight * corner - geom::to_mm(loop[i].y);
    else if (below != nullptr)
      cost += kAlignWeight * distance_mm(loop[i], *below);
    else
      cost += distance_mm(loop[i], at);
    if (cost < best) best = cost, found = i;
  }
  current_.push_back(loop[found]);
  return found;
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/travel/travel.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;

/// Detours keep this far from the outline, mm: less than the centre lines of the outer walls do.
constexpr double kClearanceMm = 0.12;
/// A detour may be this much longer than the straight way, mm and share: beyond that, a retraction is
/// quicker than the way round.
constexpr double kMaxDetourMm = 10.0;
constexpr double kMaxDetourShare = 0.3;
/// Borders are followed only where that is at most this many times the way allowed: cutting corners
/// shortens it.
constexpr double kMaxWalk = 4.0;
/// Between supports the nozzle may cross the open without retraction up to this, mm: strings there come
/// off with the support.
constexpr double kMaxOpenSupportMm = 10.0;

bool is_support(Role role) { return role == Role::support || role == Role::support_interface; }

/// The rings of an area that ways can follow.
class Border {
 public:
  explicit Border(const geom::Regions& area) : rings_(geom::rings_of(area)), grid_(area) {
    for (std::uint32_t r = 0; r < rings_.size(); ++r) {
      first_.push_back(static_cast<std::uint32_t>(ring_of_.size()));
      double along = 0;
      for (std::size_t k = 0; k < rings_[r].size(); ++k) {
        if (k > 0) along += geom::distance(rings_[r][k - 1], rings_[r][k]);
        along_.push_back(along);
        ring_of_.push_back(r);
      }
      length_.push_back(along + geom::distance(rings_[r].back(), rings_[r].front()));
    }
  }

  /// From a to b, both inside, along the borders in the way; empty when that is longer than `limit` nm or
  /// leads out of the area.
  geom::Polyline walk(const Point& a, const Point& b, double limit) const {
    if (!grid_.contains(a) || !grid_.contains(b)) return {};
    std::vector<geom::AreaGrid::Crossing> cuts;
    grid_.crossings(a, b, cuts);
    geom::Polyline way{a};
    double spent = 0;
    for (std::size_t i = 0; i < cuts.size();) {
      const std::uint32_t ring = ring_of_[cuts[i].edge];
      std::size_t last = i;
      for (std::size_t k = i + 1; k < cuts.size(); ++k)
        if (ring_of_[cuts[k].edge] == ring) last = k;
      if (last == i) return {};
      spent += follow(way, point(a, b, cuts[i].t), cuts[i].edge, point(a, b, cuts[last].t), cuts[last].edge);
      if (spent > limit) return {};
      i = last + 1;
    }
    way.push_back(b);
    return way;
  }

 private:
  static Point point(const Point& a, const Point& b, double t) {
    return {a.x + std::llround(t * static_cast<double>(b.x - a.x)),
            a.y + std::llround(t * static_cast<double>(b.y - a.y))};
  }

  /// Appends the shorter stretch of border between two points on it, and tells its length. Edge k of a ring
  /// leads to its vertex k.
  double follow(geom::Polyline& way, const Point& p, std::uint32_t p_edge, const Point& q,
                std::uint32_t q_edge) const {
    const std::uint32_t r = ring_of_[p_edge];
    const geom::Ring& ring = rings_[r];
    const auto n = static_cast<std::uint32_t>(ring.size());
    const std::uint32_t i = p_edge - first_[r], j = q_edge - first_[r];
    const double from = position(r, i, p), to = position(r, j, q);
    double ahead = to - from;
    if (ahead < 0) ahead += length_[r];
    const bool forward = ahead <= length_[r] - ahead;
    way.push_back(p);
    std::uint32_t steps = forward ? (j + n - i) % n : (i + n - j) % n;
    if (steps == 0 && (forward ? to < from : to > from)) steps = n;
    for (std::uint32_t s = 0; s < steps; ++s)
      way.push_back(ring[forward ? (i + s) % n : (i + 2 * n - 1 - s) % n]);
    way.push_back(q);
    return forward ? ahead : length_[r] - ahead;
  }

  /// Of a point on an edge, from the ring's first vertex on.
  double position(std::uint32_t r, std::uint32_t edge, const Point& p) const {
    const auto n = static_cast<std::uint32_t>(rings_[r].size());
    const std::uint32_t before = (edge + n - 1) % n;
    return along_[first_[r] + before] + geom::distance(rings_[r][before], p);
  }

  geom::Rings rings_;
  geom::AreaGrid grid_;
  std::vector<std::uint32_t> first_;    ///< edge of each ring
  std::vector<std::uint32_t> ring_of_;  ///< by edge
  std::vector<double> along_;           ///< by vertex, nm from the ring's first
  std::vector<double> length_;          ///< by ring, nm
};

class TravelPlanner {
 public:
  TravelPlanner(const LayerPlan& layer, const PrintSettings& settings)
      : layer_(layer), settings_(settings), outline_(layer.outline), support_(layer.support) {}

  Travel plan(const Point& from, const Point& to, bool among_supports) {
    const double straight = geom::distance(from, to);
    if (settings_.retract.length_mm <= 0 || straight < settings_.retract.min_travel_mm * geom::kNmPerMm)
      return {};
    if (outline_.contains(from, to)) return {};
    if (among_supports && harmless_between_supports(from, to, straight)) return {};
    if (settings_.retract.avoid_crossing_perimeters)
      if (Travel detour = around(from, to, straight); !detour.via.empty()) return detour;
    return {{}, true};
  }

 private:
  bool harmless_between_supports(const Point& from, const Point& to, double straight) {
    std::vector<geom::AreaGrid::Crossing> cuts;
    outline_.crossings(from, to, cuts);
    if (!cuts.empty()) return false;
    return straight <= kMaxOpenSupportMm * geom::kNmPerMm || support_.contains(from, to);
  }

  Travel around(const Point& from, const Point& to, double straight) {
    if (!outline_.contains(from) || !outline_.contains(to)) return {};
    const double limit = straight * (1 + kMaxDetourShare) + kMaxDetourMm * geom::kNmPerMm;
    if (!border_) border_ = std::make_unique<Border>(geom::offset(layer_.outline, -from_mm(kClearanceMm)));
    const geom::Polyline way = shortened(border_->walk(from, to, kMaxWalk * limit));
    if (way.size() < 3 || geom::length(way) > limit) return {};
    return {{way.begin() + 1, way.end() - 1}, false};
  }

  /// Leaves out what a straight line inside can skip.
  geom::Polyline shortened(const geom::Polyline& way) const {
    if (way.size() < 3) return way;
    geom::Polyline out{way.front()};
    const std::size_t last = way.size() - 1;
    for (std::size_t i = 0; i < last;) {
      std::size_t to = i + 1;
      std::size_t step = 1;
      for (; to + step <= last && outline_.contains(way[i], way[to + step]); step *= 2) to += step;
      for (; step > 0; step /= 2)
        if (to + step <= last && outline_.contains(way[i], way[to + step])) to += step;
      out.push_back(way[to]);
      i = to;
    }
    return out;
  }

  const LayerPlan& layer_;
  const PrintSettings& settings_;
  geom::AreaGrid outline_;
  geom::AreaGrid support_;
  std::unique_ptr<Border> border_;  ///< made when first needed
};

const Point& end_of(const Path& path) { return path.closed ? path.points.front() : path.points.back(); }

}  // namespace

std::vector<Travel> plan_travels(const LayerPlan& layer, const std::optional<Point>& from,
                                 const PrintSettings& settings) {
  std::vector<Travel> out(layer.paths.size());
  TravelPlanner planner(layer, settings);
  std::optional<Point> at = from;
  const Path* before = nullptr;
  for (std::size_t i = 0; i < layer.paths.size(); ++i) {
    const Path& path = layer.paths[i];
    if (path.points.size() < 2) continue;
    const bool among = before != nullptr && is_support(before->role) && is_support(path.role);
    if (at && !(*at == path.points.front())) out[i] = planner.plan(*at, path.points.front(), among);
    at = end_of(path);
    before = &path;
  }
  return out;
}

std::optional<Point> end_of_layer(const LayerPlan& layer) {
  for (std::size_t i = layer.paths.size(); i-- > 0;)
    if (layer.paths[i].points.size() > 1) return end_of(layer.paths[i]);
  return std::nullopt;
}

}  // namespace voidpath::toolpath

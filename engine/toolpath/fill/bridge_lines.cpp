#include "engine/toolpath/fill/bridge_lines.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/fill/hatch.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/walls/border.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace voidpath::toolpath {

namespace {

using geom::Point;
using geom::Polyline;

/// Ends are joined along the border over gaps up to this, in distances of strands.
constexpr double kLinkSpacings = 3.0;
/// A strand that ends in the air is led this far at most to where it can end, mm...
constexpr double kMaxLeadMm = 4.0;
/// ...and so far onto it.
constexpr double kOntoGroundMm = 0.4;
/// Such a way is looked at in this many places for whether it stays inside.
constexpr int kLeadLooks = 8;
/// Ways along the domain's border may leave it by this, mm: what rounding puts outside.
constexpr double kBorderSlackMm = 1e-4;

Point between(const Point& a, const Point& b, double t) {
  return {a.x + std::llround(t * static_cast<double>(b.x - a.x)),
          a.y + std::llround(t * static_cast<double>(b.y - a.y))};
}

class Leader {
 public:
  Leader(const geom::Region& domain, const geom::Regions& ground, const BridgeReach& reach,
         geom::Polylines& lines)
      : area_{domain},
        domain_(area_),
        border_(area_),
        ground_area_(ground),
        ground_(ground),
        reachable_(within(reach.beyond_mm)),
        reach_(reach),
        lines_(lines) {}

  void run() {
    for (Polyline& line : lines_)
      for (int end = 0; end < 2; ++end) {
        if (!held(line.front())) lead_to_ground(line);
        std::reverse(line.begin(), line.end());
      }
    for (std::size_t i = 0; i < lines_.size(); ++i)
      for (int end = 0; end < 2; ++end) {
        while (!lines_[i].empty() && !held(lines_[i].back()) && join(i)) continue;
        std::reverse(lines_[i].begin(), lines_[i].end());
      }
    std::erase_if(lines_, [](const Polyline& line) { return line.empty(); });
  }

 private:
  bool held(const Point& p) const { return ground_.contains(p); }

  geom::Regions within(double beyond_mm) const {
    return quick_intersect(ground_area_, geom::offset(area_, geom::from_mm(beyond_mm)));
  }

  bool inside(const Point& a, const Point& b, double beyond_mm) const {
    for (int k = 1; k < kLeadLooks; ++k)
      if (!near_domain(between(a, b, static_cast<double>(k) / kLeadLooks), beyond_mm)) return false;
    return true;
  }
  bool near_domain(const Point& p, double beyond_mm) const {
    const double limit = beyond_mm + kBorderSlackMm;
    return domain_.contains(p) || border_.distance_mm(p, limit) <= limit;
  }

  /// From the line's first point.
  void lead_to_ground(Polyline& line) {
    if (lead_to(reachable_, reach_.beyond_mm, line) || reach_.at_most_mm <= reach_.beyond_mm) return;
    if (!at_most_) at_most_.emplace(within(reach_.at_most_mm));
    lead_to(*at_most_, reach_.at_most_mm, line);
  }

  bool lead_to(const Border& ground, double beyond_mm, Polyline& line) const {
    const Point from = line.front();
    const Point border = ground.nearest(from, kMaxLeadMm);
    const double way = geom::distance(from, border);
    if (way <= 0 || way > kMaxLeadMm * geom::kNmPerMm) return false;
    if (!inside(from, border, beyond_mm)) return false;
    const Point onto = between(from, border, 1 + kOntoGroundMm * geom::kNmPerMm / way);
    line.insert(line.begin(), near_domain(onto, beyond_mm) ? onto : border);
    return true;
  }

  /// Goes on from the last point of line i with the line whose end is nearest, one that ends in the air as
  /// well if there is one.
  bool join(std::size_t i) {
    const Point from = lines_[i].back();
    double best = kMaxLeadMm * geom::kNmPerMm;
    bool best_held = true, at_back = false;
    std::size_t with = i;
    for (std::size_t k = 0; k < lines_.size(); ++k) {
      if (k == i || lines_[k].empty()) continue;
      for (int end = 0; end < 2; ++end) {
        const Point& to = end == 0 ? lines_[k].front() : lines_[k].back();
        const double d = geom::distance(from, to);
        if (d > kMaxLeadMm * geom::kNmPerMm) continue;
        const bool to_held = held(to);
        if (to_held > best_held || (to_held == best_held && d >= best) || !inside(from, to, reach_.beyond_mm))
          continue;
        best = d, best_held = to_held, with = k, at_back = end == 1;
      }
    }
    if (with == i) return false;
    Polyline& other = lines_[with];
    if (at_back) std::reverse(other.begin(), other.end());
    lines_[i].insert(lines_[i].end(), other.begin(), other.end());
    other.clear();
    return true;
  }

  geom::Regions area_;
  geom::AreaGrid domain_;
  Border border_;
  const geom::Regions& ground_area_;
  geom::AreaGrid ground_;
  Border reachable_;               ///< of the ground as far as strands may go
  std::optional<Border> at_most_;  ///< as far as they must where there is none; made when first wanted
  BridgeReach reach_;
  geom::Polylines& lines_;
};

}  // namespace

geom::Polylines bridge_lines(const geom::Region& domain, const geom::Regions& ground, double angle_rad,
                             double apart_mm, const BridgeReach& reach) {
  Hatch h = hatch({domain}, {angle_rad, apart_mm, true, kLinkSpacings * apart_mm});
  Leader(domain, ground, reach, h.lines).run();
  return std::move(h.lines);
}

}  // namespace voidpath::toolpath

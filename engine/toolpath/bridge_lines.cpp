#include "engine/toolpath/bridge_lines.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/border.h"
#include "engine/toolpath/hatch.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
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
  Leader(const geom::Region& domain, const geom::Regions& ground, double beyond_mm, geom::Polylines& lines)
      : domain_({domain}),
        border_({domain}),
        ground_(ground),
        reachable_(quick_intersect(ground, geom::offset({domain}, geom::from_mm(beyond_mm)))),
        beyond_mm_(beyond_mm + kBorderSlackMm),
        lines_(lines) {}

  void run() {
    for (Polyline& line : lines_)
      for (int end = 0; end < 2; ++end) {
        lead_to_ground(line);
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

  bool inside(const Point& a, const Point& b) const {
    for (int k = 1; k < kLeadLooks; ++k)
      if (!near_domain(between(a, b, static_cast<double>(k) / kLeadLooks))) return false;
    return true;
  }
  bool near_domain(const Point& p) const {
    return domain_.contains(p) || border_.distance_mm(p, beyond_mm_) <= beyond_mm_;
  }

  /// From the line's first point.
  void lead_to_ground(Polyline& line) const {
    const Point from = line.front();
    if (held(from)) return;
    const Point border = reachable_.nearest(from, kMaxLeadMm);
    const double way = geom::distance(from, border);
    if (way <= 0 || way > kMaxLeadMm * geom::kNmPerMm) return;
    if (!inside(from, border)) return;
    const Point onto = between(from, border, 1 + kOntoGroundMm * geom::kNmPerMm / way);
    line.insert(line.begin(), near_domain(onto) ? onto : border);
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
        if (to_held > best_held || (to_held == best_held && d >= best) || !inside(from, to)) continue;
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

  geom::AreaGrid domain_;
  Border border_;
  geom::AreaGrid ground_;
  Border reachable_;  ///< of the ground as far as strands may go
  double beyond_mm_;
  geom::Polylines& lines_;
};

}  // namespace

geom::Polylines bridge_lines(const geom::Region& domain, const geom::Regions& ground, double angle_rad,
                             double apart_mm, double beyond_mm) {
  Hatch h = hatch({domain}, {angle_rad, apart_mm, true, kLinkSpacings * apart_mm});
  Leader(domain, ground, beyond_mm, h.lines).run();
  return std::move(h.lines);
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/overhang/tips.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/overhang/firm.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/walls/border.h"
#include "engine/toolpath/walls/perimeters.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace voidpath::toolpath {

namespace {

/// An end this far from ground, mm, goes on to it...
constexpr double kMaxLeadMm = 1.2;
/// ...and so far onto it...
constexpr double kOntoGroundMm = 0.2;
/// ...if its bead stays inside but for this, mm...
constexpr double kOutsideMm = 0.05;
/// ...and if that turns it by no more than this cosine tells.
constexpr double kOnwards = 0.3;
/// Where there is no room for that bead, one at least so wide, mm, goes on from it.
constexpr double kLeastLeadMm = 0.2;
/// Ground no further than this, mm, may lie to the side, or back by as much as this cosine tells.
constexpr double kAsideMm = 0.2;
constexpr double kAside = -0.5;
/// Ground straight on is looked for this far and this often, mm: further on lie beads of the layer itself.
constexpr double kMaxStraightMm = 0.3;
constexpr double kStepMm = 0.05;
/// What runs along ground this near lies on it with a part of its bead, mm.
constexpr double kAlongMm = 0.1;
/// The outline hangs over by at least this, mm, where a line may.
constexpr double kLeastHangMm = 0.1;

/// Gap lines of a layer, chained where one goes on from another's end.
class Chains {
 public:
  /// `firm`: ground that was surely printed. Ends look for that if their chain is held further on; otherwise
  /// the way there would only hang longer.
  Chains(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& ground,
         const geom::Regions& firm)
      : paths_(paths), own_(own), own_border_(own), any_(ground) {
    if (firm != ground) firm_.emplace(firm);
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (is_line(paths[i]))
        for (const bool back : {false, true}) at_[key(end(i, back))].push_back(i);
  }

  /// Ends that stop in the air just before ground go on to it.
  void lead() {
    for (std::size_t i = 0; i < paths_.size(); ++i)
      for (const bool back : {false, true})
        if (is_line(paths_[i]) && at_[key(end(i, back))].size() == 1) lead(i, back);
    for (auto more = narrower_.rbegin(); more != narrower_.rend(); ++more)
      paths_.insert(paths_.begin() + static_cast<std::ptrdiff_t>(more->first), std::move(more->second));
  }

 private:
  struct Ground {
    explicit Ground(const geom::Regions& regions) : area(regions), border(regions) {}
    geom::AreaGrid area;
    Border border;
  };
  struct Way {
    double x, y;  ///< nm
  };

  static bool is_line(const Path& p) { return p.role == Role::gap_fill && !p.closed && p.points.size() > 1; }
  static std::pair<geom::Coord, geom::Coord> key(const geom::Point& p) { return {p.x, p.y}; }
  const geom::Point& end(std::size_t i, bool back) const {
    return back ? paths_[i].points.back() : paths_[i].points.front();
  }

  /// The line's point a width or more from an end: nearer ones tell little about where it leads.
  const geom::Point& before_end(std::size_t i, bool back) const {
    const geom::Polyline& line = paths_[i].points;
    const std::size_t n = line.size();
    std::size_t k = 1;
    while (k + 1 < n &&
           geom::distance(line[back ? n - 1 - k : k], end(i, back)) < paths_[i].width_mm * geom::kNmPerMm)
      ++k;
    return line[back ? n - 1 - k : k];
  }

  void lead(std::size_t i, bool back) {
    geom::Polyline& line = paths_[i].points;
    const geom::Point from = end(i, back);
    const Ground& ground = firm_ && is_held_elsewhere(i, back) ? *firm_ : any_;
    if (ground.area.contains(from)) return;
    const geom::Point before = back ? line[line.size() - 2] : line[1];
    std::optional<geom::Point> onto = by_nearest_way(ground, from, before, paths_[i].width_mm);
    if (!onto) onto = straight_on(ground, from, before, paths_[i].width_mm);
    if (!onto) return lead_narrower(ground, i, back);
    line.insert(back ? line.end() : line.begin(), *onto);
    at_.erase(key(from));
    at_[key(*onto)].push_back(i);
  }

  /// By a bead of its own, as wide as there is room for.
  void lead_narrower(const Ground& ground, std::size_t i, bool back) {
    const Path& path = paths_[i];
    const geom::Point from = end(i, back);
    const std::optional<geom::Point> onto = by_nearest_way(ground, from, before_end(i, back), kLeastLeadMm);
    if (!onto) return;
    const double half = 0.5 * path.width_mm;
    const BeadSize bead{std::min(path.width_mm, 2 * (own_border_.distance_mm(*onto, half) + kOutsideMm)),
                        path.height_mm};
    geom::Polyline line{from, *onto};
    if (!back) std::reverse(line.begin(), line.end());
    Path lead = make_path(path.role, std::move(line), false, bead.width_mm, bead.height_mm, bead.area_mm2());
    lead.max_speed_mm_s = path.max_speed_mm_s;
    narrower_.emplace_back(back ? i + 1 : i, std::move(lead));
    led_.insert(key(from));
  }

  /// Whether the chain that ends here comes to ground further on, or to where several meet.
  bool is_held_elsewhere(std::size_t i, bool back) const {
    for (std::size_t steps = 0; steps < paths_.size(); ++steps) {
      back = !back;
      const geom::Point& p = end(i, back);
      const std::vector<std::size_t>& here = at_.at(key(p));
      if (firm_->area.contains(p) || led_.count(key(p)) > 0 || here.size() > 2) return true;
      if (here.size() < 2 || here[0] == here[1]) return false;
      i = here[0] == i ? here[1] : here[0];
      back = key(end(i, true)) == key(p);
    }
    return false;
  }

  std::optional<geom::Point> by_nearest_way(const Ground& ground, const geom::Point& from,
                                            const geom::Point& before, double width_mm) const {
    const geom::Point to = ground.border.nearest(from, kMaxLeadMm);
    const double way = geom::distance(from, to);
    if (way <= 0) return std::nullopt;
    const auto dx = static_cast<double>(to.x - from.x), dy = static_cast<double>(to.y - from.y);
    const auto ux = static_cast<double>(from.x - before.x), uy = static_cast<double>(from.y - before.y);
    const double least = way <= kAsideMm * geom::kNmPerMm ? kAside : kOnwards;
    if (dx * ux + dy * uy < least * way * std::hypot(ux, uy)) return std::nullopt;
    return onto(from, {dx, dy}, way, width_mm);
  }

  /// Past a corner of the outline that stands in the nearest way.
  std::optional<geom::Point> straight_on(const Ground& ground, const geom::Point& from,
                                         const geom::Point& before, double width_mm) const {
    const double length = geom::distance(before, from);
    if (length <= 0) return std::nullopt;
    const Way u{static_cast<double>(from.x - before.x) / length,
                static_cast<double>(from.y - before.y) / length};
    for (double d = kStepMm; d <= kMaxStraightMm; d += kStepMm) {
      const double by = d * geom::kNmPerMm;
      const geom::Point at{from.x + std::llround(by * u.x), from.y + std::llround(by * u.y)};
      if (ground.area.contains(at) || ground.border.distance_mm(at, kAlongMm) < kAlongMm)
        return onto(from, {by * u.x, by * u.y}, by, width_mm);
    }
    return std::nullopt;
  }

  /// A little further than a way that long leads, if the bead has room there.
  std::optional<geom::Point> onto(const geom::Point& from, const Way& way, double length,
                                  double width_mm) const {
    const double t = 1 + kOntoGroundMm * geom::kNmPerMm / length;
    const geom::Point out{from.x + std::llround(t * way.x), from.y + std::llround(t * way.y)};
    const double room = 0.5 * width_mm - kOutsideMm;
    if (!own_.contains(from, out) || (room > 0 && own_border_.distance_mm(out, room) < room))
      return std::nullopt;
    return out;
  }

  std::vector<Path>& paths_;
  std::vector<std::pair<std::size_t, Path>> narrower_;  ///< to be inserted before the path of that number
  geom::AreaGrid own_;
  Border own_border_;
  Ground any_;
  std::optional<Ground> firm_;                                                  ///< where that is less
  std::map<std::pair<geom::Coord, geom::Coord>, std::vector<std::size_t>> at_;  ///< whose ends lie there
  std::set<std::pair<geom::Coord, geom::Coord>> led_;  ///< ends that go on by a bead of their own
};

}  // namespace

void hold_tips(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
               const geom::Regions& support) {
  const bool any = std::any_of(paths.begin(), paths.end(),
                               [](const Path& p) { return p.role == Role::gap_fill && !p.closed; });
  if (!any || own == below) return;
  const auto hanging = geom::bounds(quick_subtract(own, geom::offset(below, geom::from_mm(kLeastHangMm))));
  if (!hanging) return;
  const geom::Regions firm = firm_part(below, {}, grown(*hanging, geom::from_mm(kMaxLeadMm)));
  const geom::Regions ground = quick_unite(below, support);
  Chains(paths, own, ground, firm == below ? ground : quick_unite(firm, support)).lead();
}

}  // namespace voidpath::toolpath

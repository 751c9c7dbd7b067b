#include "engine/toolpath/tips.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/border.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/perimeters.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
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
  Chains(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& ground)
      : paths_(paths), own_(own), own_border_(own), ground_(ground), ground_border_(ground) {
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (is_line(paths[i]))
        for (const bool back : {false, true}) ++at_[key(end(i, back))];
  }

  /// Ends that stop in the air just before ground go on to it.
  void lead() {
    for (std::size_t i = 0; i < paths_.size(); ++i)
      for (const bool back : {false, true})
        if (is_line(paths_[i]) && at_[key(end(i, back))] == 1) lead(i, back);
    for (auto more = narrower_.rbegin(); more != narrower_.rend(); ++more)
      paths_.insert(paths_.begin() + static_cast<std::ptrdiff_t>(more->first), std::move(more->second));
  }

 private:
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
    if (ground_.contains(from)) return;
    const geom::Point before = back ? line[line.size() - 2] : line[1];
    std::optional<geom::Point> onto = by_nearest_way(from, before, paths_[i].width_mm);
    if (!onto) onto = straight_on(from, before, paths_[i].width_mm);
    if (!onto) return lead_narrower(i, back);
    line.insert(back ? line.end() : line.begin(), *onto);
    --at_[key(from)];
    ++at_[key(*onto)];
  }

  /// By a bead of its own, as wide as there is room for.
  void lead_narrower(std::size_t i, bool back) {
    const Path& path = paths_[i];
    const geom::Point from = end(i, back);
    const std::optional<geom::Point> onto = by_nearest_way(from, before_end(i, back), kLeastLeadMm);
    if (!onto) return;
    const double half = 0.5 * path.width_mm;
    const BeadSize bead{std::min(path.width_mm, 2 * (own_border_.distance_mm(*onto, half) + kOutsideMm)),
                        path.height_mm};
    geom::Polyline line{from, *onto};
    if (!back) std::reverse(line.begin(), line.end());
    Path lead = make_path(path.role, std::move(line), false, bead.width_mm, bead.height_mm, bead.area_mm2());
    lead.max_speed_mm_s = path.max_speed_mm_s;
    narrower_.emplace_back(back ? i + 1 : i, std::move(lead));
    --at_[key(from)];
    ++at_[key(*onto)];
  }

  std::optional<geom::Point> by_nearest_way(const geom::Point& from, const geom::Point& before,
                                            double width_mm) const {
    const geom::Point to = ground_border_.nearest(from, kMaxLeadMm);
    const double way = geom::distance(from, to);
    if (way <= 0) return std::nullopt;
    const auto dx = static_cast<double>(to.x - from.x), dy = static_cast<double>(to.y - from.y);
    const auto ux = static_cast<double>(from.x - before.x), uy = static_cast<double>(from.y - before.y);
    if (dx * ux + dy * uy < kOnwards * way * std::hypot(ux, uy)) return std::nullopt;
    return onto(from, {dx, dy}, way, width_mm);
  }

  /// Past a corner of the outline that stands in the nearest way.
  std::optional<geom::Point> straight_on(const geom::Point& from, const geom::Point& before,
                                         double width_mm) const {
    const double length = geom::distance(before, from);
    if (length <= 0) return std::nullopt;
    const Way u{static_cast<double>(from.x - before.x) / length,
                static_cast<double>(from.y - before.y) / length};
    for (double d = kStepMm; d <= kMaxStraightMm; d += kStepMm) {
      const double by = d * geom::kNmPerMm;
      const geom::Point at{from.x + std::llround(by * u.x), from.y + std::llround(by * u.y)};
      if (ground_.contains(at) || ground_border_.distance_mm(at, kAlongMm) < kAlongMm)
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
  geom::AreaGrid ground_;
  Border ground_border_;
  std::map<std::pair<geom::Coord, geom::Coord>, int> at_;  ///< how many ends lie there
};

}  // namespace

void hold_tips(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
               const geom::Regions& support) {
  const bool any = std::any_of(paths.begin(), paths.end(),
                               [](const Path& p) { return p.role == Role::gap_fill && !p.closed; });
  if (!any || own == below) return;
  if (quick_subtract(own, geom::offset(below, geom::from_mm(kLeastHangMm))).empty()) return;
  Chains(paths, own, quick_unite(below, support)).lead();
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/tips.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/border.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

namespace voidpath::toolpath {

namespace {

/// A line whose middle is beside the layer below by this share of its width still touches it.
constexpr double kCarried = 0.45;
/// A bead holds its own tip over air for this long, mm.
constexpr double kMaxTipMm = 0.4;
/// What hangs further than this is no tip, mm: cutting it would take a piece of the part.
constexpr double kMaxCutMm = 2.0;
/// An end this far from ground, mm, goes on to it...
constexpr double kMaxLeadMm = 0.7;
/// ...and so far onto it...
constexpr double kOntoGroundMm = 0.2;
/// ...if its bead stays inside but for this, mm...
constexpr double kOutsideMm = 0.04;
/// ...and if that turns it by no more than this cosine tells.
constexpr double kOnwards = 0.3;
/// The outline hangs over by at least this, mm, where a line may.
constexpr double kLeastHangMm = 0.1;

/// Gap lines of a layer, chained where one goes on from another's end.
class Chains {
 public:
  Chains(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& ground, double carried_mm)
      : paths_(paths),
        own_(own),
        own_border_(own),
        ground_(ground),
        ground_border_(ground),
        carrying_(geom::offset(ground, geom::from_mm(carried_mm))) {
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (is_line(paths[i]))
        for (const bool back : {false, true}) ++at_[key(end(i, back))];
  }

  /// Ends that stop in the air just before ground go on to it.
  void lead() {
    for (std::size_t i = 0; i < paths_.size(); ++i)
      for (const bool back : {false, true})
        if (is_line(paths_[i]) && at_[key(end(i, back))] == 1) lead(i, back);
  }

  void trim() {
    for (std::size_t i = 0; i < paths_.size(); ++i)
      for (const bool back : {false, true})
        if (is_line(paths_[i]) && at_[key(end(i, back))] == 1) trim(i, back);
    std::erase_if(paths_, [](const Path& p) { return p.points.size() < 2; });
  }

 private:
  static bool is_line(const Path& p) { return p.role == Role::gap_fill && !p.closed && p.points.size() > 1; }
  static std::pair<geom::Coord, geom::Coord> key(const geom::Point& p) { return {p.x, p.y}; }
  const geom::Point& end(std::size_t i, bool back) const {
    return back ? paths_[i].points.back() : paths_[i].points.front();
  }

  void lead(std::size_t i, bool back) {
    geom::Polyline& line = paths_[i].points;
    const geom::Point from = end(i, back);
    if (ground_.contains(from)) return;
    const geom::Point to = ground_border_.nearest(from, kMaxLeadMm);
    const double way = geom::distance(from, to);
    if (way <= 0) return;
    const geom::Point& before = back ? line[line.size() - 2] : line[1];
    const auto dx = static_cast<double>(to.x - from.x), dy = static_cast<double>(to.y - from.y);
    const auto ux = static_cast<double>(from.x - before.x), uy = static_cast<double>(from.y - before.y);
    if (dx * ux + dy * uy < kOnwards * way * std::hypot(ux, uy)) return;
    const double t = 1 + kOntoGroundMm * geom::kNmPerMm / way;
    const geom::Point onto{from.x + std::llround(t * dx), from.y + std::llround(t * dy)};
    const double room = 0.5 * paths_[i].width_mm - kOutsideMm;
    if (!own_.contains(from, onto) || (room > 0 && own_border_.distance_mm(onto, room) < room)) return;
    line.insert(back ? line.end() : line.begin(), onto);
    --at_[key(from)];
    ++at_[key(onto)];
  }

  /// Length from the end that hangs before the line finds ground, nm; all of it if it finds none.
  double hanging(std::size_t i, bool back, bool& found) const {
    geom::Polyline line = paths_[i].points;
    if (back) std::reverse(line.begin(), line.end());
    const auto pieces = carrying_.split(line);
    found = pieces.size() > 1 || (!pieces.empty() && pieces.front().inside);
    return pieces.empty() || pieces.front().inside ? 0 : geom::length(pieces.front().points);
  }

  /// The line that goes on from the far end of line i, and at which of its own ends.
  std::optional<std::pair<std::size_t, bool>> next(std::size_t i, bool back) const {
    const geom::Point& far = end(i, !back);
    if (at_.at(key(far)) != 2) return std::nullopt;
    for (std::size_t k = 0; k < paths_.size(); ++k)
      for (const bool b : {false, true})
        if (k != i && is_line(paths_[k]) && end(k, b) == far) return std::pair{k, b};
    return std::nullopt;
  }

  void trim(std::size_t i, bool back) {
    std::vector<std::pair<std::size_t, bool>> chain{{i, back}};
    double hangs = 0;
    for (bool found = false; !found;) {
      hangs += hanging(chain.back().first, chain.back().second, found);
      if (hangs > kMaxCutMm * geom::kNmPerMm) return;
      if (found) break;
      const auto more = next(chain.back().first, chain.back().second);
      if (!more) return;  // held nowhere: not a tip
      chain.push_back(*more);
    }
    double cut = hangs - kMaxTipMm * geom::kNmPerMm;
    for (const auto& [k, b] : chain) {
      if (cut <= 0) return;
      cut_off(paths_[k].points, b, cut);
    }
  }

  /// Takes `cut` nm off the line's end, or all of it; less is left of `cut`.
  static void cut_off(geom::Polyline& line, bool back, double& cut) {
    if (!back) std::reverse(line.begin(), line.end());
    while (line.size() > 1 && cut > 0) {
      const geom::Point p = line.back(), q = line[line.size() - 2];
      const double length = geom::distance(p, q);
      if (length > cut) {
        const double t = cut / length;
        line.back() = {p.x + std::llround(t * static_cast<double>(q.x - p.x)),
                       p.y + std::llround(t * static_cast<double>(q.y - p.y))};
        cut = 0;
      } else {
        line.pop_back();
        cut -= length;
      }
    }
    if (!back) std::reverse(line.begin(), line.end());
  }

  std::vector<Path>& paths_;
  geom::AreaGrid own_;
  Border own_border_;
  geom::AreaGrid ground_;
  Border ground_border_;
  geom::AreaGrid carrying_;  ///< the ground, and what a line beside it still touches
  std::map<std::pair<geom::Coord, geom::Coord>, int> at_;  ///< how many ends lie there
};

}  // namespace

void hold_tips(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
               const geom::Regions& support, double width_mm) {
  const bool any = std::any_of(paths.begin(), paths.end(),
                               [](const Path& p) { return p.role == Role::gap_fill && !p.closed; });
  if (!any || own == below) return;
  if (quick_subtract(own, geom::offset(below, geom::from_mm(kLeastHangMm))).empty()) return;
  Chains chains(paths, own, quick_unite(below, support), kCarried * width_mm);
  chains.lead();
  chains.trim();
}

}  // namespace voidpath::toolpath

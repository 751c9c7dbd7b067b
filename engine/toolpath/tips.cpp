#include "engine/toolpath/tips.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
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
/// The outline hangs over by at least this, mm, where a line may.
constexpr double kLeastHangMm = 0.1;

/// Gap lines of a layer, chained where one goes on from another's end.
class Chains {
 public:
  Chains(std::vector<Path>& paths, const geom::AreaGrid& ground) : paths_(paths), ground_(ground) {
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (is_line(paths[i]))
        for (const bool back : {false, true}) ++at_[key(end(i, back))];
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

  /// Length from the end that hangs before the line finds ground, nm; all of it if it finds none.
  double hanging(std::size_t i, bool back, bool& found) const {
    geom::Polyline line = paths_[i].points;
    if (back) std::reverse(line.begin(), line.end());
    const auto pieces = ground_.split(line);
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
  const geom::AreaGrid& ground_;
  std::map<std::pair<geom::Coord, geom::Coord>, int> at_;  ///< how many ends lie there
};

}  // namespace

void trim_tips(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
               const geom::Regions& support, double width_mm) {
  const bool any = std::any_of(paths.begin(), paths.end(),
                               [](const Path& p) { return p.role == Role::gap_fill && !p.closed; });
  if (!any || own == below) return;
  if (quick_subtract(own, geom::offset(below, geom::from_mm(kLeastHangMm))).empty()) return;
  const geom::AreaGrid ground(quick_unite(geom::offset(below, geom::from_mm(kCarried * width_mm)), support));
  Chains(paths, ground).trim();
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/overhang/hanging_fill.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/line_index.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/walls/border.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Hold is looked for this often along a line, mm.
constexpr double kLookMm = 0.1;
/// What is carried by nothing is named from this length on, mm: it gets the fan.
constexpr double kMinHangingMm = 0.3;
/// Support's lines are looked up in cells of this size, mm: about as far as they hold.
constexpr double kCellMm = 1.0;

bool is_support(const Path& p) { return p.role == Role::support || p.role == Role::support_interface; }
bool is_skin(const Path& p) {
  return !p.closed && (p.role == Role::solid_infill || p.role == Role::top_solid_infill);
}

/// What holds a layer's skins where they were left to the supports.
class Hold {
 public:
  Hold(const geom::Regions& unheld, const geom::Regions& below, const std::vector<Path>& bearer,
       double lean_mm)
      : box_(*geom::bounds(unheld)),
        unheld_(unheld),
        below_(below),
        lean_mm_(lean_mm),
        lines_(grown(box_, geom::from_mm(kCellMm)), geom::from_mm(kCellMm)) {
    for (const Path& path : bearer) {
      if (!is_support(path)) continue;
      const auto around = geom::bounds(path.points);
      if (!around || !overlap(*around, lines_.box())) continue;
      reach_ = std::max(reach_, (0.5 * path.width_mm + kBesideSupportMm) * geom::kNmPerMm);
      for (std::size_t k = 1; k < path.points.size(); ++k) lines_.add(path.points[k - 1], path.points[k]);
      if (path.closed) lines_.add(path.points.back(), path.points.front());
    }
  }

  const geom::Box& box() const { return box_; }
  /// In what was left to the supports.
  const geom::AreaGrid& unheld() const { return unheld_; }
  bool holds(const Point& p) {
    if (lines_.size() > 0 && lines_.reaches(p, reach_)) return true;
    if (!border_) border_.emplace(near_box(below_, grown(box_, geom::from_mm(kCellMm))));
    return border_->distance_mm(p, lean_mm_) <= lean_mm_;
  }

 private:
  geom::Box box_;
  geom::AreaGrid unheld_;
  const geom::Regions& below_;
  double lean_mm_;
  LineIndex lines_;
  double reach_ = 0;              ///< nm, from the middle of a line of support
  std::optional<Border> border_;  ///< of the layer below, made when first wanted
};

struct Stretch {
  geom::Polyline points;
  bool hangs = false;
};

void append(std::vector<Stretch>& to, const Point& from, const Point& end, bool hangs) {
  if (to.empty() || to.back().hangs != hangs) to.push_back({{from}, hangs});
  to.back().points.push_back(end);
}

/// The line, step by step where it was left to the supports.
std::vector<Stretch> stretches_of(const geom::Polyline& line, Hold& hold) {
  std::vector<Stretch> out;
  for (const geom::Piece& piece : hold.unheld().split(line))
    for (std::size_t k = 1; k < piece.points.size(); ++k) {
      const Point &a = piece.points[k - 1], &b = piece.points[k];
      if (!piece.inside) {
        append(out, a, b, false);
        continue;
      }
      const auto n = static_cast<int>(std::ceil(geom::distance(a, b) / (kLookMm * geom::kNmPerMm)));
      const auto at = [&](double t) {
        return Point{a.x + std::llround(t * static_cast<double>(b.x - a.x)),
                     a.y + std::llround(t * static_cast<double>(b.y - a.y))};
      };
      for (int j = 0; j < n; ++j)
        append(out, j == 0 ? a : at(static_cast<double>(j) / n),
               j + 1 == n ? b : at(static_cast<double>(j + 1) / n), !hold.holds(at((j + 0.5) / n)));
    }
  return out;
}

/// What is too short to be named joins what is beside it.
std::vector<Stretch> merged(std::vector<Stretch>&& stretches) {
  std::vector<Stretch> out;
  for (Stretch& s : stretches) {
    s.hangs = s.hangs && geom::length(s.points) >= kMinHangingMm * geom::kNmPerMm;
    if (out.empty() || out.back().hangs != s.hangs)
      out.push_back(std::move(s));
    else
      out.back().points.insert(out.back().points.end(), s.points.begin() + 1, s.points.end());
  }
  return out;
}

}  // namespace

std::optional<std::vector<Path>> bridge_hanging_fill(const std::vector<Path>& paths,
                                                     const geom::Regions& unheld, const geom::Regions& below,
                                                     const std::vector<Path>& bearer, double lean_mm) {
  if (unheld.empty() || std::none_of(paths.begin(), paths.end(), is_skin)) return std::nullopt;
  Hold hold(unheld, below, bearer, lean_mm);
  std::vector<std::pair<std::size_t, std::vector<Stretch>>> cut;
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const auto box = is_skin(paths[k]) ? geom::bounds(paths[k].points) : std::nullopt;
    if (!box || !overlap(*box, hold.box())) continue;
    std::vector<Stretch> stretches = merged(stretches_of(paths[k].points, hold));
    if (std::any_of(stretches.begin(), stretches.end(), [](const Stretch& s) { return s.hangs; }))
      cut.emplace_back(k, std::move(stretches));
  }
  if (cut.empty()) return std::nullopt;
  std::vector<Path> out;
  out.reserve(paths.size() + 2 * cut.size());
  std::size_t next = 0;
  for (auto& [k, stretches] : cut) {
    out.insert(out.end(), paths.begin() + static_cast<std::ptrdiff_t>(next),
               paths.begin() + static_cast<std::ptrdiff_t>(k));
    for (Stretch& s : stretches) {
      out.push_back(paths[k]);
      out.back().points = geom::simplify(s.points, 1);
      if (s.hangs) out.back().role = Role::bridge_infill;
    }
    next = k + 1;
  }
  out.insert(out.end(), paths.begin() + static_cast<std::ptrdiff_t>(next), paths.end());
  return out;
}

}  // namespace voidpath::toolpath

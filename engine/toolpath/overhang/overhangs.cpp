#include "engine/toolpath/overhang/overhangs.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/overhang/firm.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/walls/gap_lines.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Stretches shorter than this stay part of their wall, mm: slowing takes a way of its own.
constexpr double kMinStretchMm = 0.5;
/// What is carried by nothing is named from this length on, mm: it gets the fan.
constexpr double kMinHangingMm = 0.3;
/// A bead this much of which hangs is no longer carried, but hangs between its ends.
constexpr double kHanging = 0.75;
/// Gap lines are looked at so often, mm.
constexpr double kLookMm = 0.25;
/// What is bare below is looked at from this size on, mm: over less a line hangs no further than over a step.
constexpr double kLeastBareMm = 0.8;
/// The outline steps out by at least this share of what its outer bead's middle does; less is not looked at.
constexpr double kRoundingShare = 0.9;

/// What hangs by `share` of its bead or more.
struct Band {
  double share;
  double max_speed_mm_s;  ///< 0: not slowed
  bool overhang;          ///< printed as overhang_perimeter
};

std::vector<Band> bands_of(const SpeedSettings& speed) {
  std::vector<Band> out;
  if (speed.overhang_25 > 0) out.push_back({0.25, speed.overhang_25, false});
  if (speed.overhang_50 > 0) out.push_back({0.5, speed.overhang_50, false});
  out.push_back({kHanging, speed.overhang_75, true});
  out.push_back({1.0, 0, true});
  return out;
}

/// A stretch of a wall, and the last band it reaches: 0 none, k the k-th.
struct Stretch {
  geom::Polyline points;
  std::size_t band = 0;
};

/// The layer below, grown so that a bead whose middle leaves it hangs by the band's share. Each band's
/// boundary is made when a wall first gets that far.
class Carrier {
 public:
  Carrier(const geom::Regions& below, double width_mm, const std::vector<Band>& bands)
      : below_(below), width_mm_(width_mm), bands_(bands), grids_(bands.size()) {}

  std::vector<Stretch> split(const geom::Polyline& line) {
    std::vector<Stretch> out;
    split(line, 0, out);
    return out;
  }

 private:
  void split(const geom::Polyline& line, std::size_t band, std::vector<Stretch>& out) {
    if (band == bands_.size()) {
      out.push_back({line, band});
      return;
    }
    for (geom::Piece& piece : grid(band).split(line)) {
      if (piece.inside)
        out.push_back({std::move(piece.points), band});
      else
        split(piece.points, band + 1, out);
    }
  }

  const geom::AreaGrid& grid(std::size_t band) {
    auto& g = grids_[band];
    if (!g) {
      const geom::Coord by = from_mm((bands_[band].share - 0.5) * width_mm_);
      g.emplace(by == 0 ? below_ : geom::offset(below_, by));
    }
    return *g;
  }

  const geom::Regions& below_;
  double width_mm_;
  const std::vector<Band>& bands_;
  std::vector<std::optional<geom::AreaGrid>> grids_;
};

bool hangs(const Stretch& s, const std::vector<Band>& bands) {
  return s.band > 0 && bands[s.band - 1].overhang;
}
bool is_too_short(const Stretch& s, const std::vector<Band>& bands) {
  return geom::length(s.points) < (hangs(s, bands) ? kMinHangingMm : kMinStretchMm) * geom::kNmPerMm;
}

/// What hangs along one stretch counts together: those too short to be named join the next that hang, and
/// the longer tells the band.
std::vector<Stretch> gathered(std::vector<Stretch>&& stretches, const std::vector<Band>& bands) {
  std::vector<Stretch> out;
  for (auto& s : stretches) {
    if (out.empty() || !hangs(s, bands) || !hangs(out.back(), bands) ||
        (!is_too_short(s, bands) && !is_too_short(out.back(), bands))) {
      out.push_back(std::move(s));
      continue;
    }
    Stretch& last = out.back();
    if (geom::length(s.points) > geom::length(last.points)) last.band = s.band;
    last.points.insert(last.points.end(), s.points.begin() + 1, s.points.end());
  }
  return out;
}

/// Stretches that are too short join the one before them, and equal ones each other.
std::vector<Stretch> merged(std::vector<Stretch>&& stretches, const std::vector<Band>& bands) {
  std::vector<Stretch> out;
  for (auto& s : gathered(std::move(stretches), bands)) {
    const bool is_short = is_too_short(s, bands);
    if (!out.empty() && (is_short || out.back().band == s.band))
      out.back().points.insert(out.back().points.end(), s.points.begin() + 1, s.points.end());
    else
      out.push_back(std::move(s));
  }
  return out;
}

/// In two at its middle.
std::pair<Stretch, Stretch> halves(Stretch&& whole) {
  double left = 0.5 * geom::length(whole.points);
  std::size_t k = 1;
  double step = geom::distance(whole.points[0], whole.points[1]);
  while (step < left && k + 1 < whole.points.size()) {
    left -= step;
    step = geom::distance(whole.points[k], whole.points[k + 1]), ++k;
  }
  const double t = step > 0 ? left / step : 0;
  const geom::Point &a = whole.points[k - 1], &b = whole.points[k];
  const geom::Point middle{a.x + std::llround(t * static_cast<double>(b.x - a.x)),
                           a.y + std::llround(t * static_cast<double>(b.y - a.y))};
  const auto cut = whole.points.begin() + static_cast<std::ptrdiff_t>(k);
  Stretch first{{whole.points.begin(), cut}, whole.band}, second{{cut, whole.points.end()}, whole.band};
  first.points.push_back(middle);
  second.points.insert(second.points.begin(), middle);
  return {std::move(first), std::move(second)};
}

/// A loop whose seam hangs begins where it is carried best, and there as far as can be from where it hangs
/// more: what begins in the air holds to nothing. Whether it now begins elsewhere.
bool begin_held(std::vector<Stretch>& loop, const std::vector<Band>& bands) {
  if (loop.size() < 2 || loop.front().band == 0 || !bands[loop.front().band - 1].overhang) return false;
  if (loop.front().band == loop.back().band) {  // cut by the seam alone
    loop.back().points.insert(loop.back().points.end(), loop.front().points.begin() + 1,
                              loop.front().points.end());
    loop.front() = std::move(loop.back());
    loop.pop_back();
  }
  const auto best = std::min_element(loop.begin(), loop.end(), [](const Stretch& a, const Stretch& b) {
    return std::pair(a.band, -geom::length(a.points)) < std::pair(b.band, -geom::length(b.points));
  });
  std::rotate(loop.begin(), best, loop.end());
  auto [end, begin] = halves(std::move(loop.front()));
  loop.front() = std::move(begin);
  loop.push_back(std::move(end));
  return true;
}

/// How much of the straight line lies inside, nm.
double length_inside(const geom::AreaGrid& area, const geom::Point& a, const geom::Point& b) {
  double out = 0;
  for (const geom::Piece& piece : area.split({a, b}))
    if (piece.inside) out += geom::length(piece.points);
  return out;
}

/// How much of a line lies on what is thinner than `thin` within `reach` of it, all in nm.
double length_on_threads(const geom::Polyline& line, const geom::AreaGrid& below, double thin, double reach) {
  double out = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double length = geom::distance(line[i], line[i + 1]);
    const auto looks = static_cast<int>(std::ceil(length / (kLookMm * geom::kNmPerMm)));
    const double x = static_cast<double>(line[i + 1].x - line[i].x) / length;
    const double y = static_cast<double>(line[i + 1].y - line[i].y) / length;
    for (int k = 0; k < looks; ++k) {
      const double at = (k + 0.5) * length / looks;
      const auto beside = [&](double by) {
        return geom::Point{line[i].x + std::llround(at * x - by * y),
                           line[i].y + std::llround(at * y + by * x)};
      };
      if (length_inside(below, beside(-reach), beside(reach)) < thin) out += length / looks;
    }
  }
  return out;
}

/// Gap lines may hang though nothing steps out by `step_mm`: what is below them may be too thin to have been
/// printed. The corners of boxes around those.
geom::Ring on_threads(const std::vector<Path>& paths, const geom::Regions& below, double width_mm,
                      double step_mm) {
  const double unprinted_mm = kMinGapWidth * width_mm;
  std::optional<geom::AreaGrid> grid;
  geom::Ring out;
  for (const Path& path : paths) {
    const double reach_mm = 0.5 * path.width_mm + step_mm;
    if (path.role != Role::gap_fill || path.width_mm > unprinted_mm + 2 * step_mm) continue;
    if (!grid) grid.emplace(below);
    if (length_on_threads(path.points, *grid, unprinted_mm * geom::kNmPerMm, reach_mm * geom::kNmPerMm) <
        kMinHangingMm * geom::kNmPerMm)
      continue;
    const geom::Box box = grown(*geom::bounds(path.points), from_mm(width_mm));
    out.insert(out.end(), {box.min, box.max});
  }
  return out;
}

/// Of what is bare below: whether a line may hang over it for long.
bool is_long(const geom::Box& bare) {
  return std::max(bare.max.x - bare.min.x, bare.max.y - bare.min.y) >= from_mm(kLeastBareMm);
}

void put_in_band(Path& path, std::size_t band, const std::vector<Band>& bands) {
  if (band == 0) return;
  const Band& b = bands[band - 1];
  if (b.overhang) path.role = Role::overhang_perimeter;
  if (b.max_speed_mm_s <= 0) return;
  path.max_speed_mm_s =
      path.max_speed_mm_s > 0 ? std::min(path.max_speed_mm_s, b.max_speed_mm_s) : b.max_speed_mm_s;
}

}  // namespace

void mark_overhangs(std::vector<Path>& paths, const geom::Regions& own, const geom::Regions& below,
                    const geom::Regions& bare, double width_mm, const SpeedSettings& speed) {
  if (own == below) return;
  const std::vector<Band> bands = bands_of(speed);
  // An outer bead's middle lies half a bead inside the outline.
  const double step = bands.front().share * kRoundingShare * width_mm;
  const geom::Regions stepping = quick_subtract(own, geom::offset(below, from_mm(step)));
  geom::Ring corners = on_threads(paths, below, width_mm, step);
  if (const auto around = geom::bounds(stepping)) {
    const geom::Box box = grown(*around, from_mm(width_mm));
    corners.insert(corners.end(), {box.min, box.max});
  }
  for (const geom::Region& r : bare)
    if (const auto around = geom::bounds(r.outer); around && is_long(*around))
      corners.insert(corners.end(), {around->min, around->max});
  if (corners.empty()) return;
  const geom::Box box = *geom::bounds(corners);
  const geom::Regions firm = firm_part(below, bare, box);
  Carrier carrier(firm, width_mm, bands);
  std::vector<Path> out;
  out.reserve(paths.size());
  for (Path& path : paths) {
    const auto own_box = geom::bounds(path.points);
    // What fills the gap between two walls hangs where they do.
    const bool wall =
        path.role == Role::external_perimeter || path.role == Role::perimeter || path.role == Role::gap_fill;
    if (!wall || !own_box || !overlap(*own_box, box)) {
      out.push_back(std::move(path));
      continue;
    }
    geom::Polyline line = path.points;
    if (path.closed) line.push_back(line.front());
    std::vector<Stretch> stretches = carrier.split(line);
    const bool turned = path.closed && begin_held(stretches, bands);
    stretches = merged(std::move(stretches), bands);
    if (stretches.size() <= 1) {
      if (!stretches.empty()) {
        if (turned) {
          path.points = std::move(stretches.front().points);
          path.points.pop_back();
        }
        put_in_band(path, stretches.front().band, bands);
      }
      out.push_back(std::move(path));
      continue;
    }
    for (Stretch& s : stretches) {
      Path part = path;
      part.closed = false;
      part.points = std::move(s.points);
      put_in_band(part, s.band, bands);
      out.push_back(std::move(part));
    }
  }
  paths = std::move(out);
}

}  // namespace voidpath::toolpath

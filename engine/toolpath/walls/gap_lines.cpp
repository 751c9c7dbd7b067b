#include "engine/toolpath/walls/gap_lines.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/walls/border.h"
#include "engine/toolpath/walls/gap_fill.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Gap lines: beads stay below this width, as a share of the line width; wider is met by the walls.
constexpr double kMaxGapWidth = 2.0;
/// A gap line's bead changes when the width differs by this share.
constexpr double kGapWidthStep = 0.15;
/// Gap lines are simplified to this, mm: their place is known no better.
constexpr double kGapToleranceMm = 0.03;
/// Gap lines shorter than this many widths are blobs.
constexpr double kMinGapLength = 1.0;
/// Along a step of a gap line its width changes by this share of a bead at most, and steps are no shorter
/// than this, mm.
constexpr double kWidthChange = 0.08;
constexpr double kMinStepMm = 0.05;
/// The round end of a gap line may reach this far beyond the gap, mm.
constexpr double kEndSlackMm = 0.02;
/// What is left of a gap line that both ends are taken from, mm.
constexpr double kLeastLengthMm = 0.1;
/// Beads around it close a spot narrower than this by their squeeze, mm.
constexpr double kLeastSpotMm = 0.25;
/// Lines no longer than this many of their widths together may cover less than a spot.
constexpr double kStubbyWidths = 2.0;
/// The middle of a spot is looked for at this many places, this often, in x and in y...
constexpr geom::Coord kDotLooks = 7;
constexpr int kDotRounds = 3;
/// ...and its length in this many directions, by at least and at most this many half steps.
constexpr int kDotDirections = 12;
constexpr int kLeastDotSteps = 2;
constexpr int kDotSteps = 80;

/// The round end of a line this wide, mm, has room.
bool has_room(const Border& border, const geom::Point& p, double width_mm) {
  const double half = 0.5 * width_mm - kEndSlackMm;
  return half <= 0 || border.distance_mm(p, half) >= half;
}

/// As much of the width as there is room for, mm.
double room_mm(const Border& border, const geom::Point& p, double width_mm) {
  return std::min(width_mm, 2 * (border.distance_mm(p, 0.5 * width_mm) + kEndSlackMm));
}

/// In steps so short that the width changes but little along each.
CentreLine refined(const CentreLine& line, double most_change_mm) {
  CentreLine out;
  out.closed = line.closed;
  for (std::size_t i = 0; i + 1 < line.points.size(); ++i) {
    const geom::Point &a = line.points[i], &b = line.points[i + 1];
    const double from = line.width_mm[i], to = line.width_mm[i + 1];
    const double by_width = std::ceil(std::abs(to - from) / most_change_mm);
    const double by_length = std::floor(geom::distance(a, b) / (kMinStepMm * geom::kNmPerMm));
    const auto parts = static_cast<std::int64_t>(std::max(1.0, std::min(by_width, by_length)));
    for (std::int64_t k = 0; k < parts; ++k) {
      out.points.push_back({a.x + (b.x - a.x) * k / parts, a.y + (b.y - a.y) * k / parts});
      out.width_mm.push_back(from + (to - from) * static_cast<double>(k) / static_cast<double>(parts));
    }
  }
  out.points.push_back(line.points.back());
  out.width_mm.push_back(line.width_mm.back());
  return out;
}

/// A line whose end cannot be as wide as its middle draws back from the gap's end until it has room: from the
/// front.
void draw_back(CentreLine& line, const Border& border, double least_mm) {
  const double step = kMinStepMm * geom::kNmPerMm;
  double whole = geom::length(line.points);
  const double least = least_mm * geom::kNmPerMm;
  while (line.points.size() > 1 && whole > least) {
    geom::Point& p = line.points.front();
    if (has_room(border, p, line.width_mm.front())) return;
    const double length = geom::distance(p, line.points[1]);
    const double cut = std::min(step, whole - least);
    whole -= std::min(cut, length);
    if (length <= cut) {
      line.points.erase(line.points.begin());
      line.width_mm.erase(line.width_mm.begin());
      continue;
    }
    const double t = cut / length;
    const geom::Point& q = line.points[1];
    p = {p.x + std::llround(t * static_cast<double>(q.x - p.x)),
         p.y + std::llround(t * static_cast<double>(q.y - p.y))};
    line.width_mm.front() += t * (line.width_mm[1] - line.width_mm.front());
  }
}

/// As wide as the gap has room for at the ends of what is left, and within `outline` all along, if there is
/// one: the lengths of chords tell too much where walls meet.
void make_room(CentreLine& line, const Border& border, const Border* outline) {
  if (!line.closed && line.points.size() > 1) {
    for (int end = 0; end < 2; ++end) {
      draw_back(line, border, kLeastLengthMm);
      std::reverse(line.points.begin(), line.points.end());
      std::reverse(line.width_mm.begin(), line.width_mm.end());
    }
  }
  const std::size_t last = line.points.size() - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const bool end = !line.closed && (i == 0 || i == last);
    if (const Border* within = end ? &border : outline)
      line.width_mm[i] = room_mm(*within, line.points[i], line.width_mm[i]);
  }
  if (line.closed) return;
  // A line shorter than it is wide is all end.
  const double least = std::min(line.width_mm.front(), line.width_mm.back());
  if (geom::length(line.points) < least * geom::kNmPerMm)
    for (double& width : line.width_mm) width = std::min(width, least);
}

/// `alone`: what is thinner than the thinnest line gets that line.
void add_gap_line(std::vector<Path>& out, const CentreLine& line, const BeadSize& bead, double tolerance_mm,
                  bool alone) {
  const double low = kMinGapWidth * bead.width_mm;
  const double high = kMaxGapWidth * bead.width_mm;
  std::size_t i = 0;
  const std::size_t n = line.points.size();
  while (i + 1 < n) {
    double length = 0;
    double area = 0;  // length × width
    geom::Polyline points{line.points[i]};
    const double begin = 0.5 * (line.width_mm[i] + line.width_mm[i + 1]);
    do {
      const double d = geom::to_mm(1) * geom::distance(line.points[i], line.points[i + 1]);
      length += d;
      area += d * 0.5 * (line.width_mm[i] + line.width_mm[i + 1]);
      points.push_back(line.points[++i]);
    } while (i + 1 < n && std::abs(0.5 * (line.width_mm[i] + line.width_mm[i + 1]) - begin) <=
                              kGapWidthStep * bead.width_mm);
    if (length <= 0) continue;
    // A gap flanked by beads is as wide as a spacing; what stands alone is as wide as its line.
    const double mean = area / length;
    const double spacing =
        alone ? std::clamp(bead_spacing_mm(mean, bead.height_mm), low, high) : std::min(mean, high);
    if (spacing < low) continue;
    const bool closed = line.closed && points.size() == n && points.front() == points.back();
    points = geom::simplify(points, from_mm(std::max(tolerance_mm, kGapToleranceMm)));
    if (closed) points.pop_back();
    out.push_back(make_path(Role::gap_fill, std::move(points), closed,
                            width_of_spacing_mm(spacing, bead.height_mm), bead.height_mm,
                            spacing * bead.height_mm));
  }
}

/// A line of one step that is shorter than it is wide.
bool is_blob(const CentreLine& line) {
  return line.points.size() < 3 &&
         geom::length(line.points) <
             kMinGapLength * 0.5 * (line.width_mm.front() + line.width_mm.back()) * geom::kNmPerMm;
}

/// The border of an area, made when first wanted.
class Outline {
 public:
  explicit Outline(const geom::Region* region) : region_(region) {}
  const Border* border() {
    if (!border_ && region_ != nullptr) border_.emplace(geom::Regions{*region_});
    return border_ ? &*border_ : nullptr;
  }

 private:
  const geom::Region* region_;
  std::optional<Border> border_;
};

/// `outline`: what the gap's lines must keep inside, if anything. `alone`: the gap itself.
void add_lines_of(std::vector<Path>& out, const geom::Region& gap, const BeadSize& bead, double tolerance_mm,
                  Outline* outline, bool alone) {
  const std::vector<CentreLine> centres = centre_lines(gap);
  if (centres.empty()) return;
  const Border border({gap});
  for (const auto& centre : centres) {
    if (is_blob(centre)) continue;
    CentreLine line = refined(centre, kWidthChange * bead.width_mm);
    make_room(line, border, alone ? &border : outline != nullptr ? outline->border() : nullptr);
    add_gap_line(out, line, bead, tolerance_mm, alone);
  }
}

/// The place furthest from the border: the best of a few in the area's box, then of a few around that one.
std::optional<geom::Point> deepest(const geom::Region& area, const Border& border) {
  const auto box = geom::bounds(area.outer);
  if (!box) return std::nullopt;
  std::optional<geom::Point> best;
  double most = 0;
  const auto look = [&](const geom::Point& p) {
    if (!geom::contains(area, p)) return;
    const double d = border.distance_mm(p, std::numeric_limits<double>::max());
    if (d > most) most = d, best = p;
  };
  geom::Point low = box->min, high = box->max;
  for (int round = 0; round < kDotRounds; ++round) {
    const geom::Coord dx = high.x - low.x, dy = high.y - low.y;
    for (geom::Coord i = 0; i < kDotLooks; ++i)
      for (geom::Coord j = 0; j < kDotLooks; ++j)
        look({low.x + dx * (2 * i + 1) / (2 * kDotLooks), low.y + dy * (2 * j + 1) / (2 * kDotLooks)});
    if (!best) return best;
    low = {best->x - dx / kDotLooks, best->y - dy / kDotLooks};
    high = {best->x + dx / kDotLooks, best->y + dy / kDotLooks};
  }
  return best;
}

/// The widest round spot that has room, drawn out as long as it has; none that is narrower than `least_mm`.
void add_dot(std::vector<Path>& out, const geom::Region& area, const BeadSize& bead, double least_mm) {
  const Border border({area});
  const auto middle = deepest(area, border);
  if (!middle) return;
  const double most = kMaxGapWidth * bead.width_mm;
  const double room = std::min(most, 2 * border.distance_mm(*middle, 0.5 * most));
  if (room < least_mm) return;
  const double width = std::max(room, width_of_spacing_mm(kMinGapWidth * bead.width_mm, bead.height_mm));
  geom::Polyline line;
  double longest = -1;
  for (int k = 0; k < kDotDirections; ++k) {
    const double angle = std::numbers::pi * k / kDotDirections;
    const auto at = [&](int steps) {
      const double d = 0.5 * kMinStepMm * steps * geom::kNmPerMm;
      return geom::Point{middle->x + std::llround(d * std::cos(angle)),
                         middle->y + std::llround(d * std::sin(angle))};
    };
    const auto reach = [&](int way) {
      int steps = 0;
      while (steps < kDotSteps && has_room(border, at(way * (steps + 1)), width) &&
             geom::contains(area, at(way * (steps + 1))))
        ++steps;
      return steps;
    };
    // Out of a spot smaller than that only as far as makes it a line.
    const auto least = [&](int way) {
      return geom::contains(area, at(way * kLeastDotSteps)) ? kLeastDotSteps : 1;
    };
    const int ahead = std::max(reach(1), least(1)), behind = std::max(reach(-1), least(-1));
    if (ahead + behind > longest) longest = ahead + behind, line = {at(-behind), at(ahead)};
  }
  const double spacing = bead_spacing_mm(width, bead.height_mm);
  out.push_back(
      make_path(Role::gap_fill, std::move(line), false, width, bead.height_mm, spacing * bead.height_mm));
}

/// Of the lines from the first on, with one pair of round ends.
double covered_mm2(const std::vector<Path>& lines, std::size_t first) {
  double sum = 0, widest = 0;
  for (std::size_t i = first; i < lines.size(); ++i) {
    sum += lines[i].width_mm * geom::length(lines[i].points) / geom::kNmPerMm;
    widest = std::max(widest, lines[i].width_mm);
  }
  return sum + std::numbers::pi / 4 * widest * widest;
}

/// Hardly longer than wide, or nothing at all: a middle line says little about such an area.
bool is_stubby(const std::vector<Path>& lines, std::size_t first) {
  double length = 0, widest = 0;
  for (std::size_t i = first; i < lines.size(); ++i) {
    length += geom::length(lines[i].points) / geom::kNmPerMm;
    widest = std::max(widest, lines[i].width_mm);
  }
  return length <= kStubbyWidths * widest;
}

}  // namespace

void add_gap_lines(std::vector<Path>& out, const geom::Regions& gaps, const BeadSize& bead,
                   double tolerance_mm, const geom::Region* outline, std::size_t at_outline) {
  Outline around(outline);
  for (std::size_t k = 0; k < gaps.size(); ++k) {
    const std::size_t before = out.size();
    add_lines_of(out, gaps[k], bead, tolerance_mm, k < at_outline ? &around : nullptr, false);
    if (out.size() == before) add_dot(out, gaps[k], bead, kLeastSpotMm);
  }
}

void add_thin_lines(std::vector<Path>& out, const geom::Regions& areas, const BeadSize& bead,
                    double tolerance_mm) {
  for (const auto& area : areas) {
    const std::size_t before = out.size();
    add_lines_of(out, area, bead, tolerance_mm, nullptr, true);
    if (!is_stubby(out, before)) continue;
    std::vector<Path> dot;
    add_dot(dot, area, bead, 0);
    if (covered_mm2(dot, 0) <= covered_mm2(out, before)) continue;
    out.resize(before);
    out.insert(out.end(), std::make_move_iterator(dot.begin()), std::make_move_iterator(dot.end()));
  }
}

}  // namespace voidpath::toolpath

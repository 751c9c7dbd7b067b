#include "engine/toolpath/gap_lines.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/gap_fill.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Gap lines: beads stay within these widths, as shares of the line width; thinner is not printable,
/// wider is met by the walls.
constexpr double kMinGapWidth = 0.25;
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

/// From a point to the area's border, mm.
double border_mm(const geom::Region& area, const geom::Point& p) {
  double best = std::numeric_limits<double>::max();
  const auto look = [&](const geom::Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const geom::Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
      const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
      const auto px = static_cast<double>(p.x - a.x), py = static_cast<double>(p.y - a.y);
      const double len2 = dx * dx + dy * dy;
      const double t = len2 > 0 ? std::clamp((px * dx + py * dy) / len2, 0.0, 1.0) : 0.0;
      const double ex = px - t * dx, ey = py - t * dy;
      best = std::min(best, ex * ex + ey * ey);
    }
  };
  look(area.outer);
  for (const auto& hole : area.holes) look(hole);
  return std::sqrt(best) / geom::kNmPerMm;
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
void draw_back(CentreLine& line, const geom::Region& gap, double least_mm) {
  const double step = kMinStepMm * geom::kNmPerMm;
  double whole = geom::length(line.points);
  const double least = least_mm * geom::kNmPerMm;
  while (line.points.size() > 1 && whole > least) {
    geom::Point& p = line.points.front();
    if (border_mm(gap, p) >= 0.5 * line.width_mm.front() - kEndSlackMm) return;
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

/// As wide as the gap has room for at the ends of what is left.
void make_room(CentreLine& line, const geom::Region& gap) {
  if (line.closed || line.points.size() < 2) return;
  for (int end = 0; end < 2; ++end) {
    draw_back(line, gap, kLeastLengthMm);
    std::reverse(line.points.begin(), line.points.end());
    std::reverse(line.width_mm.begin(), line.width_mm.end());
  }
  for (const std::size_t i : {std::size_t{0}, line.points.size() - 1})
    line.width_mm[i] = std::min(line.width_mm[i], 2 * (border_mm(gap, line.points[i]) + kEndSlackMm));
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
    // The gap is flanked by beads: its width is a spacing.
    const double spacing = std::clamp(area / length, alone ? low : 0.0, high);
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

void add_lines_of(std::vector<Path>& out, const geom::Region& gap, const BeadSize& bead, double tolerance_mm,
                  bool alone) {
  for (const auto& centre : centre_lines(gap)) {
    if (is_blob(centre)) continue;
    CentreLine line = refined(centre, kWidthChange * bead.width_mm);
    make_room(line, gap);
    add_gap_line(out, line, bead, tolerance_mm, alone);
  }
}

/// As much material as the area asks for, in its middle.
void add_dot(std::vector<Path>& out, const geom::Region& area, const BeadSize& bead) {
  const auto box = geom::bounds(area.outer);
  if (!box) return;
  const geom::Point middle{(box->min.x + box->max.x) / 2, (box->min.y + box->max.y) / 2};
  if (!geom::contains(area, middle)) return;
  const double side = std::sqrt(geom::to_mm2(geom::area(area)));
  const double spacing = std::clamp(side, kMinGapWidth * bead.width_mm, kMaxGapWidth * bead.width_mm);
  const geom::Coord half = from_mm(0.5 * std::max(kLeastLengthMm, 0.5 * side));
  out.push_back(make_path(Role::gap_fill, {{middle.x - half, middle.y}, {middle.x + half, middle.y}}, false,
                          width_of_spacing_mm(spacing, bead.height_mm), bead.height_mm,
                          spacing * bead.height_mm));
}

}  // namespace

void add_gap_lines(std::vector<Path>& out, const geom::Regions& gaps, const BeadSize& bead,
                   double tolerance_mm) {
  for (const auto& gap : gaps) add_lines_of(out, gap, bead, tolerance_mm, false);
}

void add_thin_lines(std::vector<Path>& out, const geom::Regions& areas, const BeadSize& bead,
                    double tolerance_mm) {
  for (const auto& area : areas) {
    const std::size_t before = out.size();
    add_lines_of(out, area, bead, tolerance_mm, true);
    if (out.size() == before) add_dot(out, area, bead);
  }
}

}  // namespace voidpath::toolpath

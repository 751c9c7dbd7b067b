#include "engine/toolpath/gap_lines.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/gap_fill.h"

#include <algorithm>
#include <cmath>
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

void add_gap_line(std::vector<Path>& out, const CentreLine& line, const BeadSize& bead, double tolerance_mm) {
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
    const double spacing = std::min(area / length, high);
    if (spacing < low || (n < 3 && length < kMinGapLength * spacing)) continue;
    const bool closed = line.closed && points.size() == n && points.front() == points.back();
    points = geom::simplify(points, from_mm(std::max(tolerance_mm, kGapToleranceMm)));
    if (closed) points.pop_back();
    out.push_back(make_path(Role::gap_fill, std::move(points), closed,
                            width_of_spacing_mm(spacing, bead.height_mm), bead.height_mm,
                            spacing * bead.height_mm));
  }
}

}  // namespace

void add_gap_lines(std::vector<Path>& out, const geom::Regions& gaps, const BeadSize& bead,
                   double tolerance_mm) {
  for (const auto& gap : gaps)
    for (const auto& line : centre_lines(gap)) add_gap_line(out, line, bead, tolerance_mm);
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/bare.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/region_ops.h"

namespace voidpath::toolpath {

namespace {

/// What is left and thinner than this, mm, or smaller than this, mm², is rounding of corners.
constexpr double kLeastBareMm = 0.1;
constexpr double kLeastBareMm2 = 0.03;

geom::Regions covered_by_gap_lines(const std::vector<Path>& paths) {
  geom::Rings quads;
  for (const Path& path : paths) {
    if (path.role != Role::gap_fill || path.points.empty()) continue;
    geom::Polyline line = path.points;
    if (path.closed) line.push_back(line.front());
    add_beads(quads, line, path.width_mm * geom::kNmPerMm);
  }
  return geom::unite(quads);
}

}  // namespace

geom::Regions bare_parts(const LayerWalls& walls, const std::vector<Path>& paths) {
  geom::Regions narrow;
  for (const Perimeters& island : walls.islands) {
    append(narrow, geom::Regions(island.gaps));
    append(narrow, geom::Regions(island.thin));
  }
  if (narrow.empty()) return narrow;
  const geom::Regions left =
      geom::open(quick_subtract(narrow, covered_by_gap_lines(paths)), geom::from_mm(0.5 * kLeastBareMm));
  return geom::remove_small(left, kLeastBareMm2 * geom::kNmPerMm * geom::kNmPerMm);
}

}  // namespace voidpath::toolpath

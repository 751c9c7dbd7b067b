#include "engine/toolpath/draft.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/gap_fill.h"
#include "engine/toolpath/hatch.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support_lines.h"

#include <algorithm>
#include <cmath>
#include <iterator>

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
/// Sparse infill is simplified to this, mm: nobody sees it.
constexpr double kSparseToleranceMm = 0.05;
/// Gap lines shorter than this many widths are blobs.
constexpr double kMinGapLength = 1.0;

void add_bridge(std::vector<Path>& out, const BridgeArea& bridge, const BeadSize& bead,
                const PrintSettings& settings) {
  const double strand = settings.machine.nozzle_mm;
  for (const auto& domain : centre_line_area(bridge.area, bead, settings.slice.infill_overlap)) {
    Hatch h = hatch({domain}, {bridge.angle_rad, strand, true, 3 * strand});
    for (auto& line : h.lines)
      out.push_back(
          make_path(Role::bridge_infill, std::move(line), false, strand, strand, strand_area_mm2(strand)));
  }
}

/// Cuts a centre line where its width changes, each piece with the mean width of its stretch.
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

/// Hands each region to the island that holds it.
class Sharer {
 public:
  explicit Sharer(const geom::Regions& islands) : islands_(islands) {
    for (const auto& r : islands) boxes_.push_back(geom::bounds(r.outer).value_or(geom::Box{}));
  }
  std::size_t owner(const geom::Region& area) const {
    const geom::Point& p = area.outer.front();
    const geom::Box box{p, p};
    for (std::size_t i = 0; i < islands_.size(); ++i)
      if (overlap(boxes_[i], box) && (islands_.size() == 1 || geom::contains(islands_[i], p))) return i;
    return 0;
  }

 private:
  const geom::Regions& islands_;
  std::vector<geom::Box> boxes_;
};

}  // namespace

LayerWalls draft_walls(const slice::Layer& layer, std::size_t index, const SliceSettings& settings) {
  LayerWalls out;
  out.bead = bead_of_layer(settings, index, layer.span.height_mm());
  for (const auto& region : layer.regions)
    out.islands.push_back(make_perimeters(region, settings.perimeters, out.bead));
  return out;
}

geom::Regions inner_of(const LayerWalls& walls) {
  geom::Regions out;
  for (const auto& island : walls.islands) out.insert(out.end(), island.inner.begin(), island.inner.end());
  return out;
}

LayerDraft draft_layer(const slice::Layer& layer, std::size_t index, LayerWalls&& walls,
                       const Surfaces& surfaces, const SupportAreas& support, const PrintSettings& settings) {
  const SliceSettings& s = settings.slice;
  const BeadSize& bead = walls.bead;
  LayerDraft out;
  for (auto& island : walls.islands) {
    out.islands.push_back({std::move(island.walls), {}});
    for (const auto& gap : island.gaps)
      for (const auto& line : centre_lines(gap))
        add_gap_line(out.islands.back().fills, line, bead, s.resolution_mm);
  }
  const Sharer sharer(layer.regions);
  auto each = [&](const geom::Regions& areas, auto&& fill) {
    for (const auto& domain : centre_line_area(areas, bead, s.infill_overlap))
      if (!domain.outer.empty()) fill(domain, out.islands[sharer.owner(domain)].fills);
  };
  const double angle = layer_angle_rad(s, index);
  for (const auto& bridge : surfaces.bridges)
    if (!bridge.area.empty())
      add_bridge(out.islands[sharer.owner(bridge.area.front())].fills, bridge, bead, settings);
  each(surfaces.solid, [&](const geom::Region& domain, std::vector<Path>& fills) {
    add_fill(fills, Role::solid_infill, solid_fill(domain, angle, bead), bead, s.resolution_mm);
  });
  each(surfaces.sparse, [&](const geom::Region& domain, std::vector<Path>& fills) {
    add_fill(fills, Role::infill, sparse_fill(domain, s, index, layer.span, bead), bead,
             std::max(s.resolution_mm, kSparseToleranceMm));
  });
  each(surfaces.top, [&](const geom::Region& domain, std::vector<Path>& fills) {
    add_fill(fills, Role::top_solid_infill, solid_fill(domain, angle, bead), bead, s.resolution_mm);
  });
  out.support = support_lines(support, index, bead, s);
  return out;
}

}  // namespace voidpath::toolpath

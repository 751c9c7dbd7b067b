#include "engine/toolpath/draft.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/bridge_lines.h"
#include "engine/toolpath/concentric_fill.h"
#include "engine/toolpath/fermat_fill.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/gap_lines.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support_lines.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Sparse infill is simplified to this, mm: nobody sees it.
constexpr double kSparseToleranceMm = 0.05;

/// A bridge's strand may go into the walls by this much of a line width to find ground: as far as the outer
/// one.
constexpr double kIntoWallsWidths = 0.95;

void add_bridge(std::vector<Path>& out, const BridgeArea& bridge, const BeadSize& bead,
                const PrintSettings& settings) {
  const double strand = settings.machine.nozzle_mm;
  const double flow = settings.slice.bridge_flow;
  const double width = strand * std::sqrt(flow);
  const double into_walls = settings.slice.perimeters > 0 ? kIntoWallsWidths * bead.width_mm : 0;
  for (const auto& domain : centre_line_area(bridge.area, bead, fill_overlap(settings.slice, bead)))
    for (auto& line : bridge_lines(domain, bridge.ground, bridge.angle_rad, strand, into_walls))
      out.push_back(make_path(Role::bridge_infill, std::move(line), false, width, width,
                              flow * strand_area_mm2(strand)));
}

/// Lines over sparse infill: its gaps are short, so the bead keeps the layer's height.
void add_internal_bridge(std::vector<Path>& out, const geom::Region& domain, double angle_rad,
                         const BeadSize& bead, const SliceSettings& settings) {
  const std::size_t first = out.size();
  add_fill(out, Role::internal_bridge, solid_fill(domain, angle_rad, bead), bead, settings.resolution_mm);
  for (std::size_t i = first; i < out.size(); ++i) out[i].area_mm2 *= settings.bridge_flow;
}

void add_solid(std::vector<Path>& out, Role role, SolidPattern pattern, const geom::Region& domain,
               double angle_rad, const BeadSize& bead, const SliceSettings& settings) {
  if (pattern == SolidPattern::rectilinear)
    return add_fill(out, role, solid_fill(domain, angle_rad, bead), bead, settings.resolution_mm);
  RingFill fill = pattern == SolidPattern::fermat ? fermat_fill(domain, bead) : concentric_fill(domain, bead);
  add_fill(out, role, std::move(fill.lines), bead, settings.resolution_mm);
  add_gap_lines(out, fill.gaps, bead, settings.resolution_mm);
}

/// Infill of several layers at once: a bead as high as they are, at least as wide as that.
BeadSize thick_bead(const BeadSize& bead, double height_mm) {
  return {std::max(bead.width_mm, height_mm), height_mm};
}

/// Hands each region to the island that holds it.
class Sharer {
 public:
  explicit Sharer(const geom::Regions& islands) : islands_(islands) {
    for (const auto& r : islands) boxes_.push_back(geom::bounds(r.outer).value_or(geom::Box{}));
  }
  std::size_t owner(const geom::Region& area) const { return owner(area.outer.front()); }
  std::size_t owner(const geom::Point& p) const {
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

LayerDraft draft_layer(const slice::Layer& layer, std::size_t index, LayerWalls& walls,
                       const Surfaces& surfaces, const FillDirections& directions,
                       const geom::Polylines& lightning, const SupportAreas& support,
                       const PrintSettings& settings) {
  const SliceSettings& s = settings.slice;
  const BeadSize& bead = walls.bead;
  LayerDraft out;
  for (auto& island : walls.islands) {
    out.islands.push_back({std::move(island.walls), {}});
    add_gap_lines(out.islands.back().fills, island.gaps, bead, s.resolution_mm);
    add_thin_lines(out.islands.back().fills, island.thin, bead, s.resolution_mm);
  }
  const Sharer sharer(layer.regions);
  auto each = [&](const geom::Regions& areas, auto&& fill) {
    for (const auto& domain : centre_line_area(areas, bead, fill_overlap(s, bead)))
      if (!domain.outer.empty()) fill(domain, out.islands[sharer.owner(domain)].fills);
  };
  for (const auto& bridge : surfaces.bridges)
    if (!bridge.area.empty())
      add_bridge(out.islands[sharer.owner(bridge.area.front())].fills, bridge, bead, settings);
  for (const auto& bridge : surfaces.internal_bridges)
    each(bridge.area, [&](const geom::Region& domain, std::vector<Path>& fills) {
      add_internal_bridge(fills, domain, bridge.anchored ? bridge.angle_rad : directions.over_sparse, bead,
                          s);
    });
  each(surfaces.solid, [&](const geom::Region& domain, std::vector<Path>& fills) {
    add_solid(fills, Role::solid_infill, s.solid_pattern, domain, directions.solid, bead, s);
  });
  const double plain = std::max(s.resolution_mm, kSparseToleranceMm);
  if (s.infill_pattern == InfillPattern::lightning) {
    for (const auto& line : lightning)
      add_fill(out.islands[sharer.owner(line.front())].fills, Role::infill,
               {{line}, false, bead.spacing_mm()}, bead, plain);
  } else {
    each(surfaces.sparse, [&](const geom::Region& domain, std::vector<Path>& fills) {
      add_fill(fills, Role::infill, sparse_fill(domain, s, directions.sparse, layer.span, bead), bead, plain);
    });
    const BeadSize thick = thick_bead(bead, surfaces.thick_mm);
    each(surfaces.thick, [&](const geom::Region& domain, std::vector<Path>& fills) {
      add_fill(fills, Role::infill, sparse_fill(domain, s, directions.thick, layer.span, thick), thick,
               plain);
    });
  }
  each(surfaces.top, [&](const geom::Region& domain, std::vector<Path>& fills) {
    add_solid(fills, Role::top_solid_infill, s.top_pattern, domain, directions.solid, bead, s);
  });
  out.support = support_lines(support, index, bead, s);
  return out;
}

}  // namespace voidpath::toolpath

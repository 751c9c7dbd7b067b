#include "engine/toolpath/draft.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/fill/bridge_lines.h"
#include "engine/toolpath/fill/concentric_fill.h"
#include "engine/toolpath/fill/fermat_fill.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_lines.h"
#include "engine/toolpath/walls/gap_lines.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Sparse infill is simplified to this, mm: nobody sees it.
constexpr double kSparseToleranceMm = 0.05;

/// A bridge's strand may go into the walls by this much of a line width to find ground: as far as the outer
/// one.
constexpr double kIntoWallsWidths = 0.95;

/// Without walls, what the lines leave bare is filled from this width on, in widths of a line; less the
/// squeeze of the beads beside it closes.
constexpr double kLeastBareWidths = 0.5;

/// Where the centre lines of a layer's fill may run. Fill overlaps the walls as asked; without walls it
/// overlaps other fill so, and keeps half a width inside the outline.
class Domains {
 public:
  Domains(const geom::Regions& outline, const BeadSize& bead, const SliceSettings& settings)
      : bead_(bead), overlap_(settings.infill_overlap) {
    if (settings.perimeters <= 0) within_ = geom::offset(outline, -from_mm(0.5 * bead.width_mm));
  }

  geom::Regions of(const geom::Regions& area) const {
    geom::Regions out = centre_line_area(area, bead_, overlap_);
    return within_ ? quick_intersect(out, *within_) : out;
  }

  /// Of the ground of bridges: without walls the lines below may end up to a line from their outline.
  geom::Regions printed(const geom::Regions& ground) const {
    return within_ ? geom::offset(ground, -from_mm(bead_.width_mm)) : ground;
  }

  /// Without walls: none of the fill's lines may fit what of an area is narrower than this, mm.
  double least_width_mm() const { return (0.5 - overlap_) * bead_.width_mm + 1.5 * bead_.spacing_mm(); }

 private:
  const BeadSize& bead_;
  double overlap_;
  std::optional<geom::Regions> within_;
};

void add_bridge(std::vector<Path>& out, const BridgeArea& bridge, const Domains& domains,
                const BeadSize& bead, const PrintSettings& settings) {
  const double strand = settings.machine.nozzle_mm;
  const double flow = settings.slice.bridge_flow;
  const double width = strand * std::sqrt(flow);
  BridgeReach reach;
  if (const int walls = settings.slice.perimeters; walls > 0) {
    reach.beyond_mm = kIntoWallsWidths * bead.width_mm;
    // The outer wall's middle: a strand there is still inside.
    reach.at_most_mm = 0.5 * bead.width_mm + (walls - 1) * bead.spacing_mm();
  }
  const geom::Regions ground = domains.printed(bridge.ground);
  for (const auto& domain : domains.of(bridge.area))
    for (auto& line : bridge_lines(domain, ground, bridge.angle_rad, strand, reach))
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

/// What of the areas the lines leave bare: without walls a border that runs along the fill's lines may lie as
/// far as a line from the last of them.
geom::Regions left_bare(const geom::Regions& areas, const std::vector<IslandDraft>& islands,
                        const BeadSize& bead) {
  geom::Rings beads;
  for (const IslandDraft& island : islands)
    for (const Path& path : island.fills) {
      if (path.role == Role::infill) continue;
      geom::Polyline line = path.points;
      if (path.closed) line.push_back(line.front());
      add_beads(beads, line, path.width_mm * geom::kNmPerMm);
    }
  const double least = kLeastBareWidths * bead.width_mm;
  const geom::Regions bare = geom::open(quick_subtract(areas, geom::unite(beads)), from_mm(0.5 * least));
  return geom::remove_small(bare, least * bead.width_mm * geom::kNmPerMm * geom::kNmPerMm);
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
  for (std::size_t k = 0; k < walls.islands.size(); ++k) {
    Perimeters& island = walls.islands[k];
    out.islands.push_back({std::move(island.walls), {}});
    add_gap_lines(out.islands.back().fills, island.gaps, bead, s.resolution_mm, &layer.regions[k],
                  island.at_outline);
    add_thin_lines(out.islands.back().fills, island.thin, bead, s.resolution_mm);
  }
  const Sharer sharer(layer.regions);
  const Domains domains(layer.regions, bead, s);
  auto each = [&](const geom::Regions& areas, auto&& fill) {
    for (const auto& domain : domains.of(areas))
      if (!domain.outer.empty()) fill(domain, out.islands[sharer.owner(domain)].fills);
  };
  for (const auto& bridge : surfaces.bridges)
    if (!bridge.area.empty())
      add_bridge(out.islands[sharer.owner(bridge.area.front())].fills, bridge, domains, bead, settings);
  for (const auto& bridge : surfaces.internal_bridges)
    each(bridge.area, [&](const geom::Region& domain, std::vector<Path>& fills) {
      add_internal_bridge(fills, domain, bridge.anchored ? bridge.angle_rad : directions.over_sparse, bead,
                          s);
    });
  geom::Regions skins;  // without walls
  auto solid = [&](const geom::Regions& areas, Role role, SolidPattern pattern) {
    const auto add = [&](const geom::Region& domain, std::vector<Path>& fills) {
      add_solid(fills, role, pattern, domain, directions.solid, bead, s);
    };
    if (s.perimeters > 0) return each(areas, add);
    geom::Regions strips, wide = areas;
    take_strips(strips, wide, domains.least_width_mm(), bead);
    for (const auto& strip : strips)
      add_gap_lines(out.islands[sharer.owner(strip)].fills, {strip}, bead, s.resolution_mm);
    each(wide, add);
    append(skins, std::move(wide));
  };
  solid(surfaces.solid, Role::solid_infill, s.solid_pattern);
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
  solid(surfaces.top, Role::top_solid_infill, s.top_pattern);
  if (s.perimeters <= 0)
    for (const auto& bridge : surfaces.bridges) append(skins, geom::Regions(bridge.area));
  if (!skins.empty())
    for (auto& strip : left_bare(skins, out.islands, bead)) {
      const std::size_t owner = sharer.owner(strip);
      add_gap_lines(out.islands[owner].fills, {strip}, bead, s.resolution_mm);
      // It stays bare where its lines hang.
      walls.islands[owner].gaps.push_back(std::move(strip));
    }
  out.support = support_lines(support, index, bead, s);
  return out;
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/support/support_lines.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/fill/hatch.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_borders.h"
#include "engine/toolpath/walls/gap_fill.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Regions;

/// Density of support on the plate, where it must hold.
constexpr double kFirstLayerDensity = 0.5;
/// Lines are joined over gaps up to this, in their own spacings.
constexpr double kLinkSpacings = 1.6;
/// Lines of support are simplified to this, mm: they only have to be there.
constexpr double kLineToleranceMm = 0.05;
/// Sparse lines shorter than this share of their width are hardly more than a dot, and carry nothing.
constexpr double kLeastLineShare = 0.5;
/// An area that is narrow by more than this share needs no lines across.
constexpr double kAllNarrow = 0.9;
/// Branches whose middle is further than this from their border get a second wall, mm.
constexpr double kThickBranchMm = 1.6;

/// Lines along the border of an area too narrow for lines across; one down its middle where two have no
/// room side by side.
void add_border(std::vector<Path>& out, Role role, const geom::Region& area, const BeadSize& bead,
                double tolerance_mm) {
  const double spacing = bead.spacing_mm();
  if (!geom::offset({area}, -from_mm(0.5 * spacing)).empty()) {
    add_fill(out, role, {geom::rings_of({area}), true, spacing}, bead, tolerance_mm);
    return;
  }
  std::vector<CentreLine> middle = centre_lines(area);
  // What is hardly longer than wide has no middle line.
  if (middle.empty()) add_fill(out, role, {geom::rings_of({area}), true, spacing}, bead, tolerance_mm);
  for (auto& line : middle) {
    if (line.closed) line.points.pop_back();
    add_fill(out, role, {{std::move(line.points)}, line.closed, spacing}, bead, tolerance_mm);
  }
}

/// Dense lines along y, from border to border and no sparser than asked for: what lies on them ends no
/// further beside than the gap that support keeps. Where the area is too narrow to be sure of one of them,
/// its border is printed; all around if `all_round`.
void add_dense(std::vector<Path>& out, const Regions& areas, bool all_round, const BeadSize& bead,
               const SliceSettings& settings, double tolerance_mm) {
  const double spacing = bead.spacing_mm();
  const double apart = support_line_distance_mm(settings, kInterfaceDensity);
  for (const auto& area : areas) {
    const Regions domains = geom::offset({area}, -from_mm(0.5 * bead.width_mm));
    for (const auto& domain : domains) {
      Regions across{domain};
      if (all_round || geom::offset(across, -from_mm(0.5 * apart)).empty()) {
        add_border(out, Role::support_interface, domain, bead, tolerance_mm);
        across = geom::offset(across, -from_mm(apart));
      }
      Hatch h = hatch(across, {std::numbers::pi / 2, apart, true, kLinkSpacings * apart, 1.0});
      add_fill(out, Role::support_interface, {std::move(h.lines), false, spacing}, bead, tolerance_mm);
    }
    if (domains.empty()) add_border(out, Role::support_interface, area, bead, tolerance_mm);
  }
}

/// Whether the area needs no lines across.
bool all_bordered(const geom::Region& domain, const Regions& bordered) {
  return geom::area(quick_intersect({domain}, bordered)) > kAllNarrow * geom::area(domain);
}

/// Branches of trees: a wall, two where they are thick, and lines across on the plate.
void add_branches(std::vector<Path>& out, const Regions& branches, bool on_plate, const BeadSize& bead,
                  double tolerance_mm) {
  const double spacing = bead.spacing_mm();
  for (const auto& region : branches) {
    const Regions wall = geom::offset({region}, -from_mm(0.5 * bead.width_mm));
    if (wall.empty()) {
      add_border(out, Role::support, region, bead, tolerance_mm);
      continue;
    }
    add_fill(out, Role::support, {geom::rings_of(wall), true, spacing}, bead, tolerance_mm);
    const Regions inside = geom::offset(wall, -from_mm(spacing));
    if (!geom::offset({region}, -from_mm(kThickBranchMm)).empty())
      add_fill(out, Role::support, {geom::rings_of(inside), true, spacing}, bead, tolerance_mm);
    if (!on_plate) continue;
    const double apart = spacing / kFirstLayerDensity;
    Hatch h = hatch(geom::offset(inside, -from_mm(spacing)), {0.0, apart, false, kLinkSpacings * apart});
    add_fill(out, Role::support, {std::move(h.lines), false, spacing}, bead, tolerance_mm);
  }
}

}  // namespace

std::vector<Path> support_lines(const SupportAreas& areas, std::size_t layer, const BeadSize& bead,
                                const SliceSettings& settings) {
  std::vector<Path> out;
  const double spacing = bead.spacing_mm();
  const double tolerance = std::max(settings.resolution_mm, kLineToleranceMm);
  if (settings.support_density > 0) {
    double apart = support_line_distance_mm(settings, settings.support_density);
    // Lines above lie on some of the first layer's.
    if (layer == 0) apart /= std::ceil(std::max(kFirstLayerDensity / settings.support_density, 1.0));
    for (const auto& part : areas.bordered) add_border(out, Role::support, part, bead, tolerance);
    add_fill(out, Role::support, {areas.caps, false, spacing}, bead, tolerance);
    Regions domains = geom::offset(areas.sparse, -from_mm(0.5 * bead.width_mm));
    if (layer == 0 && !areas.bordered.empty()) {
      domains = quick_subtract(domains, areas.bordered);
      append(domains, geom::offset(areas.bordered, -from_mm(spacing)));
    }
    for (const auto& domain : domains) {
      if (layer != 0 && !areas.bordered.empty() && all_bordered(domain, areas.bordered)) continue;
      const geom::Coord shift = areas.lattice ? areas.lattice->shift_at(domain.outer.front()) : 0;
      Regions shifted{domain};
      geom::translate(shifted, {0, -shift});
      Hatch h = hatch(shifted, {0.0, apart, false, kLinkSpacings * apart});
      std::erase_if(h.lines, [&](const geom::Polyline& line) {
        return geom::length(line) < kLeastLineShare * bead.width_mm * geom::kNmPerMm;
      });
      for (auto& line : h.lines)
        for (geom::Point& p : line) p.y += shift;
      add_fill(out, Role::support, {std::move(h.lines), false, spacing}, bead, tolerance);
    }
  }
  add_branches(out, areas.branches, layer == 0, bead, tolerance);
  add_dense(out, areas.floor, true, bead, settings, tolerance);
  add_dense(out, areas.interface, false, bead, settings, tolerance);
  return out;
}

}  // namespace voidpath::toolpath

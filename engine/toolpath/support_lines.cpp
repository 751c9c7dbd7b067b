#include "engine/toolpath/support_lines.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/gap_fill.h"
#include "engine/toolpath/hatch.h"

#include <algorithm>
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
/// Remainders of wide columns smaller than this need no line of their own, mm²: the rest carries them.
constexpr double kMinRestMm2 = 4.0;
/// Lines of support are simplified to this, mm: they only have to be there.
constexpr double kLineToleranceMm = 0.05;
/// An area that is narrow by more than this share needs no lines across.
constexpr double kAllNarrow = 0.9;
/// Branches whose middle is further than this from their border get a second wall, mm.
constexpr double kThickBranchMm = 1.6;
/// Borders of columns may be this much plainer than the column, mm.
constexpr double kBorderToleranceMm = 0.1;

/// Lines along the border of an area too narrow for lines across; one down its middle where two have no
/// room side by side.
void add_border(std::vector<Path>& out, const geom::Region& area, const BeadSize& bead, double tolerance_mm) {
  const double spacing = bead.spacing_mm();
  if (!geom::offset({area}, -from_mm(0.5 * spacing)).empty()) {
    add_fill(out, Role::support, {geom::rings_of({area}), true, spacing}, bead, tolerance_mm);
    return;
  }
  for (auto& line : centre_lines(area)) {
    if (line.closed) line.points.pop_back();
    add_fill(out, Role::support, {{std::move(line.points)}, line.closed, spacing}, bead, tolerance_mm);
  }
}

/// The parts of an area that lines this far apart may miss.
Regions narrow_parts(const geom::Region& area, double apart_mm, double line_mm) {
  constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;
  const geom::Coord half = from_mm(0.5 * apart_mm);
  const Regions plain = geom::simplify({area}, from_mm(kBorderToleranceMm));
  const Regions core = geom::offset(plain, -half);
  if (core.empty()) return plain;
  const Regions wide = geom::offset(core, half);
  if (geom::area(plain) - geom::area(wide) < kMinRestMm2 * kMm2) return {};
  return geom::remove_small(geom::open(geom::subtract(plain, wide), from_mm(0.5 * line_mm)),
                            kMinRestMm2 * kMm2);
}

/// Branches of trees: a wall, two where they are thick, and lines across on the plate.
void add_branches(std::vector<Path>& out, const Regions& branches, bool on_plate, const BeadSize& bead,
                  double tolerance_mm) {
  const double spacing = bead.spacing_mm();
  for (const auto& region : branches) {
    const Regions wall = geom::offset({region}, -from_mm(0.5 * bead.width_mm));
    if (wall.empty()) {
      add_border(out, region, bead, tolerance_mm);
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
  auto fill = [&](const Regions& regions, double density, double angle, Role role) {
    if (regions.empty() || density <= 0) return;
    const double apart = spacing / std::min(density, 1.0);
    const bool sparse = apart > 2 * spacing;
    for (const auto& domain : geom::offset(regions, -from_mm(0.5 * bead.width_mm))) {
      const Regions narrow = sparse ? narrow_parts(domain, apart, spacing) : Regions{};
      for (const auto& part : narrow) add_border(out, part, bead, tolerance);
      const double bordered = geom::area(narrow);
      if (bordered > kAllNarrow * geom::area(domain)) continue;
      Hatch h = hatch({domain}, {angle, apart, false, kLinkSpacings * apart});
      add_fill(out, role, {std::move(h.lines), false, spacing}, bead, tolerance);
    }
  };
  const double density =
      layer == 0 ? std::max(settings.support_density, kFirstLayerDensity) : settings.support_density;
  fill(areas.sparse, density, 0.0, Role::support);
  add_branches(out, areas.branches, layer == 0, bead, tolerance);
  fill(areas.interface, kInterfaceDensity, std::numbers::pi / 2, Role::support_interface);
  return out;
}

}  // namespace voidpath::toolpath

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
/// Remainders of columns smaller than this need no line of their own, mm².
constexpr double kMinRestMm2 = 0.5;

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
  const Regions wide = geom::open({area}, from_mm(0.5 * apart_mm));
  if (wide.empty()) return {area};
  const Regions rest = geom::open(geom::subtract({area}, wide), from_mm(0.25 * line_mm));
  return geom::remove_small(rest, kMinRestMm2 * geom::kNmPerMm * geom::kNmPerMm);
}

}  // namespace

std::vector<Path> support_lines(const SupportAreas& areas, std::size_t layer, const BeadSize& bead,
                                const SliceSettings& settings) {
  std::vector<Path> out;
  const double spacing = bead.spacing_mm();
  auto fill = [&](const Regions& regions, double density, double angle, Role role) {
    if (regions.empty() || density <= 0) return;
    const double apart = spacing / std::min(density, 1.0);
    const bool sparse = apart > 2 * spacing;
    for (const auto& domain : geom::offset(regions, -from_mm(0.5 * bead.width_mm))) {
      const Regions narrow = sparse ? narrow_parts(domain, apart, spacing) : Regions{};
      for (const auto& part : narrow) add_border(out, part, bead, settings.resolution_mm);
      if (narrow.size() != 1 || narrow.front() != domain) {
        Hatch h = hatch({domain}, {angle, apart, false, kLinkSpacings * apart});
        add_fill(out, role, {std::move(h.lines), false, spacing}, bead, settings.resolution_mm);
      }
    }
  };
  const double density =
      layer == 0 ? std::max(settings.support_density, kFirstLayerDensity) : settings.support_density;
  fill(areas.sparse, density, 0.0, Role::support);
  fill(areas.interface, kInterfaceDensity, std::numbers::pi / 2, Role::support_interface);
  return out;
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/adhesion/raft.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill/hatch.h"
#include "engine/toolpath/fill_paths.h"

#include <algorithm>
#include <numbers>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;

/// Share of the plate that the base covers: enough to stick, with room to be squeezed into.
constexpr double kBaseDensity = 0.7;
/// Share that the layers between base and dense layers cover.
constexpr double kMiddleDensity = 0.5;
/// Holes and gaps in a raft narrower than twice this are filled, mm.
constexpr double kCloseMm = 4.0;
/// Lines are joined over gaps up to this, in their own spacings.
constexpr double kLinkSpacings = 1.6;
/// The raft's outline is simplified to this, mm: only its place matters.
constexpr double kOutlineToleranceMm = 0.1;

double layer_height_mm(std::size_t i, const SliceSettings& s) {
  return i == 0 ? s.first_layer_height_mm : s.layer_height_mm;
}

}  // namespace

double raft_lift_mm(const SliceSettings& s) {
  if (s.raft_layers <= 0) return 0;
  return s.first_layer_height_mm + (s.raft_layers - 1) * s.layer_height_mm + s.raft_gap_mm;
}

SliceSettings above_raft(const SliceSettings& settings) {
  SliceSettings s = settings;
  if (s.raft_layers <= 0) return s;
  s.first_layer_line_width_mm = s.line_width_mm;
  s.elephant_foot_mm = 0;
  s.brim_width_mm = 0;
  return s;
}

void stand_on_raft(std::vector<Path>& support, const SliceSettings& settings) {
  if (settings.raft_layers <= 0) return;
  for (Path& path : support) {
    path.height_mm += settings.raft_gap_mm;
    path.area_mm2 = bead_area_mm2(path.width_mm, path.height_mm);
  }
}

Raft make_raft(const geom::Regions& footprint, const SliceSettings& s) {
  Raft raft;
  if (s.raft_layers <= 0 || footprint.empty()) return raft;
  raft.lift_mm = raft_lift_mm(s);
  const geom::Regions grown = geom::offset(geom::simplify(footprint, from_mm(kOutlineToleranceMm)),
                                           from_mm(s.raft_margin_mm + kCloseMm), geom::Join::round);
  raft.area = geom::simplify(geom::offset(grown, -from_mm(kCloseMm)), from_mm(kOutlineToleranceMm));
  const auto count = static_cast<std::size_t>(s.raft_layers);
  const auto dense = std::min(static_cast<std::size_t>(std::max(s.raft_interface_layers, 0)), count - 1);
  double bottom = 0;
  for (std::size_t i = 0; i < count; ++i) {
    RaftLayer layer;
    const bool top = i >= count - dense;
    layer.span = {bottom, bottom + layer_height_mm(i, s)};
    bottom = layer.span.top_mm;
    layer.bead = bead_of_layer(s, i, layer.span.height_mm());
    const double spacing = layer.bead.spacing_mm();
    const double apart = top ? spacing : spacing / (i == 0 ? kBaseDensity : kMiddleDensity);
    const double angle = (i % 2 == 0 ? 0.0 : 0.5) * std::numbers::pi;
    for (const auto& domain : geom::offset(raft.area, -from_mm(0.5 * layer.bead.width_mm))) {
      Hatch h = hatch({domain}, {angle, apart, top, kLinkSpacings * apart});
      const double line = top ? h.spacing_mm : spacing;
      add_fill(layer.lines, top ? Role::support_interface : Role::support, {std::move(h.lines), false, line},
               layer.bead, kOutlineToleranceMm);
    }
    raft.layers.push_back(std::move(layer));
  }
  return raft;
}

}  // namespace voidpath::toolpath

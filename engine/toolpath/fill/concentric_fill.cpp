#include "engine/toolpath/fill/concentric_fill.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/region_ops.h"

#include <limits>
#include <utility>

namespace voidpath::toolpath {

geom::Regions around_centre_lines(const geom::Region& domain, const BeadSize& bead) {
  return geom::offset({domain}, geom::from_mm(0.5 * bead.width_mm));
}

RingFill concentric_fill(const geom::Region& domain, const BeadSize& bead) {
  RingFill out{{{}, true, bead.spacing_mm()}, {}};
  for (const auto& area : around_centre_lines(domain, bead)) {
    Perimeters rings = make_perimeters(area, std::numeric_limits<int>::max(), bead);
    for (auto& wall : rings.walls)
      for (auto& loop : wall) out.lines.lines.push_back(std::move(loop.ring));
    append(out.gaps, std::move(rings.gaps));
  }
  return out;
}

}  // namespace voidpath::toolpath

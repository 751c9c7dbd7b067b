#include "engine/toolpath/bead_area.h"

#include "engine/geom/polygon_ops.h"

#include <cmath>
#include <cstddef>

namespace voidpath::toolpath {

namespace {

/// A round end is nearly as wide as its bead for this share of its radius.
constexpr double kRoundTip = 0.5;

}  // namespace

void add_beads(geom::Rings& quads, const geom::Polyline& line, double width_nm) {
  for (std::size_t i = 1; i < line.size(); ++i) {
    const geom::Point &a = line[i - 1], &b = line[i];
    const double d = geom::distance(a, b);
    if (d <= 0) continue;
    const double ux = static_cast<double>(b.x - a.x) / d, uy = static_cast<double>(b.y - a.y) / d;
    const double side = 0.5 * width_nm, tip = kRoundTip * side;
    const auto at = [&](const geom::Point& p, double along, double left) {
      return geom::Point{p.x + std::llround(along * ux - left * uy),
                         p.y + std::llround(along * uy + left * ux)};
    };
    quads.push_back({at(a, -tip, -side), at(b, tip, -side), at(b, tip, side), at(a, -tip, side)});
  }
}

geom::Regions bead_area(const geom::Polylines& lines, double width_nm) {
  geom::Rings quads;
  for (const geom::Polyline& line : lines) add_beads(quads, line, width_nm);
  return geom::unite(quads);
}

}  // namespace voidpath::toolpath

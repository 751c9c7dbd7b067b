#include "engine/toolpath/overhang/firm.h"

#include "engine/geom/polygon_ops.h"
#include "engine/toolpath/region_ops.h"

namespace voidpath::toolpath {

namespace {

/// Of the layer below, what is thinner than this carries no line, mm.
constexpr double kFirmMm = 0.25;
/// What is taken away takes so much along, mm: else rounding leaves slivers along its border.
constexpr double kRoundingMm = 0.002;

}  // namespace

geom::Regions firm_part(const geom::Regions& below, const geom::Regions& bare, const geom::Box& box) {
  const geom::Coord width = geom::from_mm(kFirmMm);
  // Cut off at a distance, so that the cut itself leaves nothing thin.
  const geom::Box around = grown(box, 2 * width);
  const geom::Regions near = quick_intersect(below, {{geom::make_rectangle(around.min, around.max), {}}});
  geom::Regions thin = quick_subtract(near, geom::open(near, width / 2));
  if (!thin.empty()) thin = quick_intersect(thin, {{geom::make_rectangle(box.min, box.max), {}}});
  const geom::Regions taken = quick_unite(thin, near_box(bare, box));
  return quick_subtract(below, geom::offset(taken, geom::from_mm(kRoundingMm)));
}

}  // namespace voidpath::toolpath

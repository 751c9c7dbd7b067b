#include "engine/orient/slabs.h"

#include "engine/orient/cross_section.h"
#include "engine/orient/directions.h"
#include "engine/orient/slice_fill.h"
#include "engine/orient/slice_regions.h"
#include "engine/orient/solid.h"
#include "engine/orient/trapped_volume.h"

#include <algorithm>

namespace voidpath::orient {

namespace {

std::vector<SlabMeasure> slabs_along(const Solid& solid, const Vec3& direction, const SearchOptions& options,
                                     const run::Context& ctx) {
  // As the search does: the line is looked at one way, whichever of its two directions is asked for.
  const bool against = !is_canonical(direction);
  const Vec3 d = (against ? Vec3(-direction) : direction).normalized() + Vec3::Zero();
  Projection p;
  project(solid, d, p);
  std::vector<Slab> slabs;
  find_slabs(solid, d, p.h, p.h_min, p.h_max, options, slabs);
  CrossSections sections;
  sections.prepare(solid, p, slabs);
  SliceFill fill;
  fill.prepare(solid, p, slabs);
  SliceRegions regions;
  std::vector<SlabMeasure> out;
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    const double weight = against ? slabs[i].weight_down : slabs[i].weight_up;
    if (weight <= 0) continue;
    ctx.check();
    sections.trace(i);
    sections.place();
    const bool told = fill.settle(i, sections);
    const SliceMeasure m = told ? regions.measure_told(sections.points(), sections.contours())
                                : regions.measure(sections.points(), sections.contours());
    const double half = 0.5 * weight * (p.h_max - p.h_min);
    const double middle = against ? p.h_max - slabs[i].middle_mm : slabs[i].middle_mm - p.h_min;
    out.push_back({middle - half, middle + half, m.regions, m.mean_distance_mm});
  }
  if (against) std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace

std::vector<std::vector<SlabMeasure>> slabs_of(const mesh::TriangleMesh& mesh,
                                               const std::vector<Vec3>& directions,
                                               const SearchOptions& options, const run::Context& ctx) {
  const Solid solid = prepare_solid(mesh, ctx);
  std::vector<std::vector<SlabMeasure>> out;
  out.reserve(directions.size());
  for (const Vec3& d : directions) out.push_back(slabs_along(solid, d, options, ctx));
  return out;
}

}  // namespace voidpath::orient

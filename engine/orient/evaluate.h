#pragma once

#include "engine/orient/search.h"
#include "engine/orient/slice_fill.h"
#include "engine/orient/slice_regions.h"
#include "engine/orient/solid.h"

#include <array>
#include <string>
#include <vector>

namespace voidpath::orient {

/// What is known of one direction.
struct Evaluation {
  Criteria criteria;
  std::string why_not;  ///< printable when empty
};

/// Looks at a part along one line at a time, both ways at once. One per thread.
class DirectionEvaluator {
 public:
  DirectionEvaluator(const Solid& solid, const std::vector<Index>& hull_vertices,
                     const SearchOptions& options)
      : solid_(solid), hull_vertices_(hull_vertices), options_(options), raster_(solid) {}

  /// For d and for -d. `d` is the canonical one of the two, so that what a direction gets does not depend on
  /// who else is looked at.
  std::array<Evaluation, 2> evaluate(const Vec3& d);

 private:
  const Solid& solid_;
  const std::vector<Index>& hull_vertices_;
  const SearchOptions& options_;
  Projection projection_;
  std::vector<Slab> slabs_;
  CrossSections sections_;
  SliceFill fill_;
  SliceRegions regions_;
  TrappedVolumeRaster raster_;
};

/// Every direction, on all threads; in the order given.
std::vector<Evaluation> evaluate_all(const Solid& solid, const std::vector<Vec3>& directions,
                                     const SearchOptions& options, const run::Context& ctx);

/// Of one direction only the height and whether it can be printed, for which prepare_standing() is enough.
Evaluation evaluate_standing(const Solid& solid, const Vec3& direction, const PrintLimits& limits);

}  // namespace voidpath::orient

#pragma once

#include "engine/orient/search.h"

#include <vector>

namespace voidpath::orient {

/// What the representative slice of one slab says (§3.2.2). Heights in mm above the plate.
struct SlabMeasure {
  double bottom_mm = 0;
  double top_mm = 0;
  double contours = 0;  ///< regions of the slice
  double void_mm = 0;   ///< mean distance over all their pairs
};

/// The slabs of each direction, lowest first, without gaps from the plate to the top: what C and D of a
/// search with the same options are the averages of, weighted by thickness. Throws run::Stopped.
std::vector<std::vector<SlabMeasure>> slabs_of(const mesh::TriangleMesh& mesh,
                                               const std::vector<Vec3>& directions,
                                               const SearchOptions& options, const run::Context& ctx = {});

}  // namespace voidpath::orient

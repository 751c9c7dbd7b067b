#pragma once

#include "engine/orient/search.h"

#include <vector>

/// The criteria by the plainest means that could be written, sharing no code with the engine: every slab cut
/// by looking at every triangle, contours matched by their edges, nesting by counting crossings, distances
/// between all segments of all pairs, trapped volume by sorting what each vertical line meets.
namespace voidpath::test {

struct ReferenceOptions {
  bool morse = false;
  double normal_tolerance_deg = 5;
  double min_slab_mm = 0.5;
  int columns = 400;  ///< vertical lines each way; V only
};

/// For meshes whose shells do not cross.
orient::Criteria reference_criteria(const mesh::TriangleMesh& mesh, const geom::Vec3& d,
                                    const ReferenceOptions& options = {});

/// Volume of the box around the part as seen along d: what errors of V are measured by.
double bounding_volume(const mesh::TriangleMesh& mesh, const geom::Vec3& d);

}  // namespace voidpath::test

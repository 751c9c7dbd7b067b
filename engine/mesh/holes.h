#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstddef>

namespace voidpath::mesh {

struct HoleReport {
  std::size_t holes_filled = 0;
  std::size_t triangles_added = 0;
};

/// Closes with facets the rings of edges walked more often one way than the other, where their shell is more
/// than an open sheet. The facets of a shell must agree.
HoleReport fill_holes(TriangleMesh& mesh);

}  // namespace voidpath::mesh

#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstddef>

namespace voidpath::mesh {

/// Closes gaps where surfaces meet but do not share vertices. Only sides of one facet, and their vertices,
/// are touched: a sound mesh never is.
struct SeamReport {
  std::size_t vertices_merged = 0;
  std::size_t triangles_added = 0;  ///< by cutting facets at vertices that lie on their sides
};

/// Merges open sides that run along each other within a small fraction of the size; the facets that
/// collapse by it keep a corner twice.
SeamReport merge_open_sides(TriangleMesh& mesh);
/// Cuts facets whose open side has vertices of other open sides on it (T-junctions).
SeamReport cut_at_open_vertices(TriangleMesh& mesh);

}  // namespace voidpath::mesh

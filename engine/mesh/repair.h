#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstddef>
#include <string>
#include <vector>

namespace voidpath::mesh {

/// What repair() changed; all zero for a sound mesh.
struct RepairReport {
  std::size_t vertices_merged = 0;
  std::size_t degenerate_removed = 0;
  std::size_t duplicates_removed = 0;
  std::size_t faces_flipped = 0;
  std::size_t shells_inverted = 0;
  std::size_t holes_filled = 0;
  std::size_t triangles_added = 0;
  std::size_t open_edges_left = 0;
  bool changed() const {
    return vertices_merged + degenerate_removed + duplicates_removed + faces_flipped + shells_inverted +
               triangles_added >
           0;
  }
  /// One short sentence a thing, for the user.
  std::vector<std::string> sentences() const;
};

/// Welds near vertices (within a named fraction of the size), drops degenerate and duplicate facets,
/// makes the facets of a shell agree, turns shells outwards (inner shells inwards), fills small holes.
/// A sound mesh comes back unchanged; repairing twice equals repairing once.
RepairReport repair(TriangleMesh& mesh);

}  // namespace voidpath::mesh

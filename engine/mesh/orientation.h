#pragma once

#include "engine/mesh/edges.h"

#include <cstdint>
#include <vector>

namespace voidpath::mesh {

/// Which facets must be turned round so that neighbours agree and shells look outwards.
struct Orientation {
  std::vector<bool> flip;
  std::size_t faces_flipped = 0;    ///< disagreed with the larger part of their patch
  std::size_t shells_inverted = 0;  ///< turned round as a whole
};

/// Terms: a patch is what hangs together over edges of exactly two facets; within it all facets follow the
/// side that has more area. A body is one or more patches that close each other at edges of several facets.
/// A body outside all others is turned outwards. One inside another keeps its sense relative to that other:
/// a cavity stays a cavity and an insert an insert, even in a file that is inside out as a whole.
Orientation solve_orientation(const TriangleMesh& mesh, const EdgeTable& edges);
/// Only makes the facets of each patch agree.
Orientation agree_in_patches(const TriangleMesh& mesh, const EdgeTable& edges);

void apply(const Orientation& orientation, TriangleMesh& mesh);

}  // namespace voidpath::mesh

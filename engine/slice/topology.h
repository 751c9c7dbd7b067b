#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace voidpath::slice {

/// Half-edge 3·t + k runs along triangle t from its corner k to its corner (k + 1) mod 3.
using HalfEdge = std::uint32_t;
inline constexpr HalfEdge kNoTwin = std::numeric_limits<HalfEdge>::max();

/// For each half-edge one other that runs along the same two vertices the other way, or kNoTwin at an
/// open or misoriented edge. Where more than two facets meet, half-edges are paired in the order of
/// the triangles: whichever pairs are made, winding numbers in a cut are the same.
std::vector<HalfEdge> edge_twins(std::span<const mesh::Triangle> triangles, std::size_t vertex_count);

}  // namespace voidpath::slice

#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstddef>

namespace voidpath::mesh {

/// Facts about a mesh, nothing changed.
struct MeshReport {
  std::size_t triangles = 0;
  std::size_t vertices = 0;
  Vec3 size_mm = Vec3::Zero();
  double volume_mm3 = 0;
  double surface_mm2 = 0;
  std::size_t shells = 0;              ///< connected over shared edges
  std::size_t open_edges = 0;          ///< used by one facet
  std::size_t non_manifold_edges = 0;  ///< used by more than two facets
  std::size_t misoriented_edges = 0;   ///< used by two facets that run along it the same way
  std::size_t flipped_faces = 0;       ///< facets that look inwards, found against their shell
  std::size_t degenerate_faces = 0;    ///< no area, or a corner used twice
  std::size_t duplicate_faces = 0;     ///< the same three corners as an earlier facet
  bool watertight() const { return open_edges == 0 && misoriented_edges == 0; }
};

MeshReport inspect(const TriangleMesh& mesh);

}  // namespace voidpath::mesh

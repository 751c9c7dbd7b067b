#include "engine/mesh/inspect.h"

#include "engine/mesh/degenerate.h"
#include "engine/mesh/edges.h"
#include "engine/mesh/orientation.h"

#include <algorithm>

namespace voidpath::mesh {

MeshReport inspect(const TriangleMesh& mesh) {
  MeshReport r;
  r.triangles = mesh.triangles.size();
  r.vertices = mesh.vertices.size();
  r.size_mm = bounds(mesh).size();
  r.volume_mm3 = volume(mesh);
  r.surface_mm2 = surface_area(mesh);

  const EdgeTable edges(mesh);
  UnionFind shells(mesh.triangles.size());
  edges.for_each([&](std::uint32_t, std::uint32_t, std::span<const EdgeUse> uses) {
    if (uses.size() == 1) ++r.open_edges;
    if (uses.size() > 2) ++r.non_manifold_edges;
    if (uses.size() == 2 && edge_begin(mesh, uses[0].slot) == edge_begin(mesh, uses[1].slot)) {
      ++r.misoriented_edges;
    }
    for (std::size_t i = 1; i < uses.size(); ++i)
      shells.unite(facet_of(uses[0].slot), facet_of(uses[i].slot));
  });

  const Twins twins = find_twins(mesh, edges);
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) {
    const Triangle& t = mesh.triangles[f];
    if (has_no_area(mesh, t)) ++r.degenerate_faces;
    if (has_repeated_corner(t)) continue;
    if (shells.find(f) == f) ++r.shells;
    if (twins.first[f] != f) ++r.duplicate_faces;
  }
  const Orientation orientation = solve_orientation(mesh, edges);
  r.flipped_faces =
      static_cast<std::size_t>(std::count(orientation.flip.begin(), orientation.flip.end(), true));
  return r;
}

}  // namespace voidpath::mesh

#pragma once

#include "engine/geom/polygon.h"
#include "engine/mesh/triangle_mesh.h"
#include "engine/slice/topology.h"

#include <cstdint>
#include <vector>

namespace voidpath::slice {

/// What a plane cuts out of a mesh. Material lies left of every line where facets look outwards.
/// No point repeats its predecessor.
struct Contours {
  geom::Rings closed;
  geom::Polylines open;  ///< end at open or misoriented edges of the mesh
};

/// Prepared to be cut by many planes, each in any thread.
///
/// A vertex lies above a plane when its z is at or above the plane's. A facet with vertices on both
/// sides is cut in one segment, from its edge that runs down through the plane (in the facet's own
/// winding) to the one that runs up. The next segment lies in the facet across that edge: contours are
/// walked from facet to facet, with no tolerance.
class Sections {
 public:
  /// `heights_mm` must not decrease. Both arguments must outlive this.
  Sections(const mesh::TriangleMesh& mesh, const std::vector<double>& heights_mm);

  /// Marks which facets a plane's walk has met; one for each thread.
  using Scratch = std::vector<std::uint32_t>;
  Contours contours(std::size_t plane, Scratch& scratch) const;

 private:
  bool is_above(std::uint32_t vertex, std::size_t plane) const { return level_[vertex] > plane; }
  /// Bit k set: corner k of the facet is above.
  unsigned corners_above(std::uint32_t facet, std::size_t plane) const;
  geom::Point crossing(HalfEdge edge, double z) const;

  const mesh::TriangleMesh& mesh_;
  const std::vector<double>& heights_mm_;
  std::vector<std::uint32_t> level_;         ///< of each vertex: how many planes it is at or above
  std::vector<mesh::Triangle> facets_;       ///< those that some plane cuts
  std::vector<HalfEdge> twins_;              ///< of facets_
  std::vector<std::size_t> first_of_plane_;  ///< into cut_
  std::vector<std::uint32_t> cut_;           ///< facets by plane
};

}  // namespace voidpath::slice

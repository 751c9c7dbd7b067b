#pragma once

#include "engine/mesh/triangle_mesh.h"

namespace voidpath::test {

struct TrappedReference {
  double up_mm3 = 0;    ///< V of d
  double down_mm3 = 0;  ///< V of -d
  double off_mm3 = 0;   ///< by how much the two looks that these are means of differ at most
};

/// V by what `lines` times `lines` vertical lines meet, twice: the gaps between material of non-zero winding,
/// the plate and the topmost surface. Lines lie at random in their cells, in rows turned two ways that have
/// nothing to do with the part, so that no pattern of a part keeps step with them. Shares no code with the
/// engine.
TrappedReference trapped_reference(const mesh::TriangleMesh& mesh, const geom::Vec3& d, int lines);

}  // namespace voidpath::test

#pragma once

#include "engine/orient/hull2d.h"
#include "engine/orient/search.h"
#include "engine/orient/solid.h"

#include <optional>
#include <string>
#include <vector>

/// Whether a part can be printed with a direction up.
namespace voidpath::orient {

enum class End { bottom, top };  ///< of the projection: which of the two lies on the plate

/// Why the part cannot be printed standing on that end, in words; empty if it can. Checks, in this order: it
/// fits the build volume, turned about the build axis as it may be; enough of it touches the plate; its
/// centre of mass lies over what touches. Contact is the plate's view of the facets within
/// PrintLimits::contact_depth_mm of it.
std::string why_not_printable(const Solid& solid, const std::vector<Index>& hull_vertices,
                              const Projection& p, End end, const PrintLimits& limits);

/// How far to turn the part about the build axis (rad, after mesh::turned(mesh, direction)) so that it fits
/// the bed: 0 if it fits as it is, nothing when no turn does. The height is not looked at.
std::optional<double> bed_turn(const mesh::TriangleMesh& mesh, const Vec3& direction,
                               const PrintLimits& limits);

}  // namespace voidpath::orient

#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/run/context.h"

#include <vector>

/// What a part rests on and what hangs over, from its facets alone: no slicing.
namespace voidpath::pipeline {

struct Underside {
  double contact_mm2 = 0;   ///< area that lies on the plate
  double overhang_mm2 = 0;  ///< area, seen from above, of facets that lean out too far and don't lie on it
};

struct UndersideOptions {
  double overhang_deg = 45;       ///< from vertical; what leans out further counts
  double contact_depth_mm = 0.2;  ///< facets wholly this near to the plate lie on it
};

/// Of each direction; on all threads. Throws run::Stopped.
std::vector<Underside> undersides(const mesh::TriangleMesh& mesh, const std::vector<geom::Vec3>& directions,
                                  const UndersideOptions& options, const run::Context& ctx);

/// How bad a direction is by overhang and contact alone: (overhang + s) / (contact + s), with s a hundredth
/// of the part's surface, so that it stays finite on a point and still tells a large foot from a larger one
/// where nothing hangs over. After the idea of Tweaker (C. Schranz, "Tweaker – Auto Rotation Module for FDM
/// 3D Printing", 2016): least overhang with the largest area on the plate; the formula is our own.
double unprintability(const Underside& underside, double surface_mm2);

}  // namespace voidpath::pipeline

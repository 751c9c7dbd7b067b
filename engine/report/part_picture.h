#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/report/void_columns.h"

#include <string>

namespace voidpath::report {

/// A part on the plate and what lies empty beneath it.
struct Standing {
  mesh::TriangleMesh mesh;  ///< on z = 0, as mesh::turned() leaves it
  mesh::Bounds box;
  VoidColumns columns;
  double overhang_deg;

  Standing(mesh::TriangleMesh part, double overhang)
      : mesh(std::move(part)), box(mesh::bounds(mesh)), columns(mesh, overhang), overhang_deg(overhang) {}
};

/// What pictures to be compared share.
struct Frame {
  double px_per_mm = 1;
  double width = 0, height = 0;  ///< of the drawing, px
};
/// The frame both parts fit in, at one scale.
Frame common_frame(const Standing& a, const Standing& b);

/// SVG: the part seen from the front, right and above in parallel projection, shaded; facets that need
/// support and the space beneath them coloured. At most some 500 kB, whatever the mesh: it is drawn as rows
/// of equal colour, coarser where a finer picture would be larger.
std::string part_picture(const Standing& part, const Frame& frame, const std::string& label);

}  // namespace voidpath::report

#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/run/context.h"

#include <cstdint>
#include <vector>

/// Pictures of a part.
namespace voidpath::render {

/// Rows from the top, 4 bytes a pixel: red, green, blue, opacity; colours not multiplied by opacity.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;
};

/// The mesh from the front, a little from the right and from above, in parallel projection, as large as the
/// picture holds, on a transparent ground. Flat shading with a fixed light; the same bytes on every machine.
/// Width and height 1 to 4096 pixels. Throws run::Stopped.
Picture draw(const mesh::TriangleMesh& mesh, int width, int height, const run::Context& ctx = {});

}  // namespace voidpath::render

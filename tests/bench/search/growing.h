#pragma once

#include "engine/mesh/triangle_mesh.h"

namespace voidpath::bench {

/// A closed body as a scanner sees one: a ball of 80 mm with waves and grooves a few millimetres deep and the
/// noise of a scan, about `triangles` triangles of even size. The same shape for any number, and every time.
mesh::TriangleMesh rippled_ball(std::size_t triangles);

}  // namespace voidpath::bench

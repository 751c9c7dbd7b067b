#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"

#include <vector>

namespace voidpath::slice {

struct SliceOptions {
  /// Open ends of contours this near are joined: small cracks in a mesh.
  double gap_close_mm = 0.05;
  /// Contours are simplified to this (Douglas-Peucker); 0 keeps every point.
  double resolution_mm = 0.0;
};

/// Cuts the mesh at each span's middle; spans must ascend. Frame: the mesh's own, which must stand on z = 0.
///
/// Rule for planes that graze the mesh: a vertex exactly at the height counts as above it. So a
/// horizontal face at the plane belongs to what lies below it, no segment is ever doubled, and every
/// contour of a closed mesh closes.
/// Fill rule: non-zero winding, so overlapping shells unite and inner shells are holes.
/// Contours left open by a hole in the mesh are closed by their shortest gap (see stitch.h).
/// The same bytes come out on one thread or many. Throws run::Stopped.
LayerStack slice_mesh(const mesh::TriangleMesh& mesh, const std::vector<LayerSpan>& spans,
                      const SliceOptions& options = {}, const run::Context& ctx = {});

/// One cut at any height: its regions.
geom::Regions slice_at(const mesh::TriangleMesh& mesh, double z_mm, const SliceOptions& options = {});

}  // namespace voidpath::slice

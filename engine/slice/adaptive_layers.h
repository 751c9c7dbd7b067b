#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"

#include <vector>

namespace voidpath::slice {

struct AdaptiveOptions {
  double first_layer_mm = 0.2;
  double min_mm = 0.08;
  double max_mm = 0.28;
  /// What a layer's steps may lie off the sloping surface in it, on average, mm along the surface's normal.
  double error_mm = 0.03;
};

/// Layer heights are whole multiples of this, mm.
inline constexpr double kAdaptiveStepMm = 0.01;

/// Layers between the least and the greatest height: thick where the surface is steep or upright, thin where
/// it is flat, with borders between layers on horizontal faces. The fewest layers that keep the error in
/// each of them, except in those of the least height; among these, the ones that miss or add the least
/// volume (after Alexa, Hase and Hildebrand, "Optimal Discrete Slicing", 2017: dynamic programming over
/// heights on a lattice). Above a first layer of its own; the top is met to within half the least height.
/// The mesh stands on z = 0. Throws std::invalid_argument for limits that don't hold a multiple of the step.
std::vector<LayerSpan> adaptive_layers(const mesh::TriangleMesh& mesh, const AdaptiveOptions& options,
                                       const run::Context& ctx = {});

}  // namespace voidpath::slice

#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <cstddef>
#include <vector>

namespace voidpath::toolpath {

/// From the part's cuts to ordered extrusion paths: perimeters, top and bottom skins found by comparing
/// layers, bridges, sparse infill, supports, skirt and brim. The stack is in plate coordinates already
/// (see place_on_bed). Deterministic, whatever the number of threads. Throws run::Stopped.
Plan build(const slice::LayerStack& stack, const PrintSettings& settings, const run::Context& ctx = {});

/// A run of layers of the stack that one of them stands for.
struct LayerGroup {
  std::size_t first = 0;
  std::size_t count = 1;
  std::size_t sample = 0;  ///< in the run
};

/// As build(), but only the groups' samples are planned: one LayerPlan a group, in order. The groups ascend
/// and cover the stack. Exact but for supports, which are found with the groups as layers, and for what a
/// layer takes over from the one below (where it begins, where seams are). `dense_mm2`: by group, the area of
/// support interface in it; samples of groups thicker than the interface are planned with all their support
/// sparse. For estimates, and not for what joins layers: a raft, trees of support, lightning, infill of
/// several layers at once. Throws run::Stopped.
struct SampledPlan {
  Plan plan;
  std::vector<double> dense_mm2;
};
SampledPlan build_samples(const slice::LayerStack& stack, const std::vector<LayerGroup>& groups,
                          const PrintSettings& settings, const run::Context& ctx = {});

/// Moves a part that is centred on (0, 0) to the middle of the bed.
void place_on_bed(slice::LayerStack& stack, const MachineShape& machine);

}  // namespace voidpath::toolpath

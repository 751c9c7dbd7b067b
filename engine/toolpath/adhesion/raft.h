#pragma once

#include "engine/geom/polygon.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/walls/perimeters.h"

#include <vector>

/// What a part stands on in the plate's stead: a thick open base, layers between, and dense ones on top with
/// air above, so that the part comes off.
namespace voidpath::toolpath {

struct RaftLayer {
  slice::LayerSpan span;
  BeadSize bead;
  std::vector<Path> lines;
};

struct Raft {
  std::vector<RaftLayer> layers;
  geom::Regions area;
  double lift_mm = 0;  ///< what stands on it is printed this much higher
};

/// Under everything that would stand on the plate. Nothing without `footprint` or raft_layers.
Raft make_raft(const geom::Regions& footprint, const SliceSettings& settings);

/// Of the raft and the air above it, mm; 0 without a raft.
double raft_lift_mm(const SliceSettings& settings);

/// Settings for what is printed on a raft: its first layer is one like the others, without brim.
SliceSettings above_raft(const SliceSettings& settings);

/// A support's first layer lies on the raft itself: its beads are thicker by the air below the part.
void stand_on_raft(std::vector<Path>& support, const SliceSettings& settings);

}  // namespace voidpath::toolpath

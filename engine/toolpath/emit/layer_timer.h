#pragma once

#include "engine/motion/limits.h"
#include "engine/toolpath/emit/pace.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/travel/travel.h"

#include <cstddef>
#include <vector>

namespace voidpath::toolpath {

/// How long a layer takes by the firmware's own planner: corners, accelerations and retractions counted, the
/// way to its first path and the serial line left out. Arcs count as the chords they stand for.
class LayerTimer {
 public:
  /// `travels`: the ways to the layer's paths; without any they are straight and nothing is retracted.
  /// Keeps references to all it is given.
  LayerTimer(const LayerPlan& layer, std::size_t index, const PrintSettings& settings,
             const motion::MachineLimits& limits, const std::vector<Travel>& travels)
      : layer_(layer), index_(index), settings_(settings), limits_(limits), travels_(travels) {}

  double seconds(const Pace& pace) const;

 private:
  const LayerPlan& layer_;
  std::size_t index_;
  const PrintSettings& settings_;
  const motion::MachineLimits& limits_;
  const std::vector<Travel>& travels_;
};

}  // namespace voidpath::toolpath

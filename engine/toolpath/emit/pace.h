#pragma once

#include "engine/motion/limits.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/travel/travel.h"

#include <cstddef>
#include <vector>

/// How fast each path is printed and how much the fan blows.
namespace voidpath::toolpath {

/// The path's speed by its role and layer, within the filament's flow limit, mm/s.
double path_speed_mm_s(const Path& path, std::size_t layer, const PrintSettings& settings);

/// The path's acceleration by its role and layer, mm/s²; 0: the printer's own.
double path_acceleration_mm_s2(const Path& path, std::size_t layer, const PrintSettings& settings);

/// Whether slowing for cooling leaves the role alone: a strand over air sags when it is printed slowly.
bool keeps_speed(Role role);

struct Pace {
  /// Speeds of paths that may be slowed are multiplied by this, but stay above the floor.
  double factor = 1;
  double floor_mm_s = 0;
  double seconds = 0;     ///< of the layer at this pace
  double fan = 0;         ///< 0 to 1
  double bridge_fan = 0;  ///< the same over air

  double apply(double speed_mm_s, Role role) const;
};

/// For one layer, whose `travels` plan_travels() found. Layers that are long enough whatever the corners cost
/// have the seconds of their lengths at their speeds; all others are timed by the printer's planner, and
/// slowed no further than that asks for.
Pace pace_of_layer(const LayerPlan& layer, std::size_t index, const PrintSettings& settings,
                   const motion::MachineLimits& limits = {}, const std::vector<Travel>& travels = {});

}  // namespace voidpath::toolpath

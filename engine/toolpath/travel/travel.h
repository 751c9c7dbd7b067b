#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <optional>
#include <vector>

namespace voidpath::toolpath {

/// The way to a path: straight, or by way of points that keep the nozzle over the part.
struct Travel {
  geom::Polyline via;  ///< without the ends
  bool retract = false;
};

/// The ways to each of a layer's paths in order, the first of them from `from`. What the nozzle oozes on the
/// way shows only where it leaves the part or strikes it: such ways are retracted, unless a short detour
/// keeps inside. Paths of fewer than two points are not printed and have no way.
std::vector<Travel> plan_travels(const LayerPlan& layer, const std::optional<geom::Point>& from,
                                 const PrintSettings& settings);

/// Where the nozzle is after the layer; nothing if it prints nothing.
std::optional<geom::Point> end_of_layer(const LayerPlan& layer);

}  // namespace voidpath::toolpath

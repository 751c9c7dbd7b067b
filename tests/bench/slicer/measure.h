#pragma once

#include "engine/gcode/estimate.h"
#include "engine/motion/limits.h"
#include "engine/slice/layer.h"

#include <cstddef>
#include <filesystem>

namespace voidpath::bench {

/// What a G-code file asks of the printer, read from the file alone.
struct Print {
  double seconds = 0;
  double filament_m = 0;
  double travel_m = 0;
  double travel_outside_m = 0;  ///< over no material of the part
  std::size_t retractions = 0;
  std::size_t moves = 0;
};

/// `stack`: the part's own cuts on the plate. A travel belongs to the layer whose top is nearest to its
/// height. Throws std::runtime_error when the file cannot be read.
Print measure(const std::filesystem::path& gcode, const slice::LayerStack& stack,
              const motion::MachineLimits& limits);

}  // namespace voidpath::bench

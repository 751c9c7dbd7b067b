#pragma once

#include "engine/gcode/estimate.h"

#include <filesystem>
#include <string>
#include <vector>

namespace voidpath::evaluate {

/// Time of every layer by feature.
struct LayerTimes {
  gcode::Estimate estimate;
  std::vector<std::string> features;         ///< as comments name them, the longest first
  std::vector<std::vector<double>> seconds;  ///< [feature][layer]; travel and retraction count to the feature
};                                           ///< whose lines ask for them

/// Times the file and tells its layers' features apart; where no comment names any, all is one feature.
/// Throws as gcode::estimate_file().
LayerTimes time_layers(const std::filesystem::path& file, const motion::MachineLimits& limits,
                       const run::Context& ctx = {});

/// One HTML page that loads nothing from elsewhere: time by layer and feature as a picture, totals, what the
/// serial line costs.
std::string layer_page(const std::string& title, const LayerTimes& times);

}  // namespace voidpath::evaluate

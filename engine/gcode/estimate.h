#pragma once

#include "engine/motion/limits.h"
#include "engine/run/context.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace voidpath::gcode {

struct LayerTime {
  double z_mm = 0;
  std::uint32_t first_line = 0;  ///< 0-based index of the file's line that opens the layer
  double seconds = 0;
};

/// Times from the printer's own planner. Seconds and millimetres.
struct Estimate {
  /// All motion and dwelling, without heating, and without the homing before the first other move.
  double predicted_s = 0;
  /// The part of predicted_s that comes after the last wait for a temperature before the first extrusion:
  /// what a host can measure between the end of heating and the end of the print.
  double after_heating_s = 0;
  double extruding_s = 0;
  double travel_s = 0;
  double retract_s = 0;
  double dwell_s = 0;
  double homing_s = 0;
  /// Extra time because the serial line cannot feed the moves fast enough; part of predicted_s.
  double serial_limited_s = 0;
  std::size_t moves = 0;
  std::size_t blocks = 0;
  std::size_t lines = 0;
  double extruding_mm = 0;
  double travel_mm = 0;
  double filament_mm = 0;
  std::size_t retractions = 0;
  std::map<std::string, double> by_feature;  ///< seconds by `;TYPE:` name, where comments tell
  std::vector<LayerTime> layers;
  /// "profile", or "G-code" where M201/M203/M204/M205 in the file replaced the profile's.
  std::string limits_from = "profile";
  std::vector<std::string> notes;
};

/// Told when each piece of motion begins and ends, in order: the file's line (0-based) that asked for it and
/// seconds on predicted_s' clock. An arc is several pieces; a line too short to move by itself is none.
using OnMotion = std::function<void(std::size_t line, double begin_s, double end_s)>;

/// Reads G-code (any slicer's) and times it, streaming, in constant memory but for the list of layers.
/// Lines are counted as in the file. Throws std::runtime_error if the stream fails; run::Stopped.
Estimate estimate(std::istream& in, const motion::MachineLimits& limits, const run::Context& ctx = {},
                  const OnMotion& on_motion = {});
/// Throws std::runtime_error naming the file when it cannot be read or is not G-code text.
Estimate estimate_file(const std::filesystem::path& file, const motion::MachineLimits& limits,
                       const run::Context& ctx = {}, const OnMotion& on_motion = {});

}  // namespace voidpath::gcode

#pragma once

#include <array>
#include <optional>

namespace voidpath::motion {

enum class Axis { x = 0, y = 1, z = 2, e = 3 };
/// One value an axis: x, y, z, e.
using PerAxis = std::array<double, 4>;

enum class Firmware { marlin, s3g };

/// In which form the host sends a line.
enum class LineFormat {
  plain,   ///< as the G-code has it
  dense,   ///< moves without blanks
  packed,  ///< MeatPack: those, and the commonest characters two in a byte
};

/// How the stepper interrupt turns a block into steps.
enum class Stepping {
  marlin_2_0,    ///< 2.0 up to 2.1.2: deceleration ends early (see planner.h)
  marlin_2_1_3,  ///< reworked: close to the ideal trapezoid
  ideal          ///< continuous trapezoids
};

/// What the printer's firmware allows, as it stands at power-on; M201/M203/M204/M205 in the G-code change
/// the planner's copy. The `machine:` section of a printer profile.
struct MachineLimits {
  Firmware firmware = Firmware::marlin;
  Stepping stepping = Stepping::marlin_2_0;
  PerAxis steps_per_mm = {80, 80, 400, 93};
  PerAxis max_speed_mm_s = {500, 500, 10, 60};
  PerAxis max_acceleration_mm_s2 = {1500, 1500, 100, 5000};
  double print_acceleration_mm_s2 = 1000;
  double retract_acceleration_mm_s2 = 1500;
  double travel_acceleration_mm_s2 = 1500;
  double junction_deviation_mm = 0.013;
  /// Classic jerk; when set, junction_deviation_mm is not used.
  std::optional<PerAxis> jerk_mm_s;
  double min_speed_mm_s = 0;         ///< M205 S
  double min_travel_speed_mm_s = 0;  ///< M205 T
  int block_buffer = 16;             ///< planner blocks; one less is usable
  double min_segment_time_us = 20000;
  /// Longest axis travel, for homing.
  std::array<double, 3> travel_mm = {250, 210, 210};
  std::array<double, 3> homing_speed_mm_s = {50, 50, 4};
  int rx_bytes = 128;
  int command_queue = 4;
  LineFormat line_format = LineFormat::plain;
  double baud = 115200;  ///< of the serial line that feeds it; 0: the line never is the brake
};

}  // namespace voidpath::motion

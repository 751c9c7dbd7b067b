#pragma once

#include "tests/mock_printer/fault_script.h"
#include "tests/mock_printer/motion_settings.h"
#include "tests/mock_printer/thermal.h"

#include <array>
#include <cstdint>
#include <vector>

namespace voidpath::test::mock {

/// A Replicator 2 with Sailfish, unless said otherwise. Times in s on the printer's clock. A and B share the
/// extruder's settings.
struct S3gOptions {
  MotionSettings motion = replicator_motion();
  std::size_t block_buffer = 16;
  std::size_t queue_bytes = 512;
  int tools = 1;
  bool heated_bed = false;
  double baud = 0;          ///< 0: the wire costs no time
  double round_trip_s = 0;  ///< half of it each way
  double boot_s = 0;
  bool counts_lines = true;  ///< the line counter of query 24 works
  bool tells_position = true;  ///< query 21
  bool advanced_version = true;
  double turnaround_s = 0;  ///< from a packet's last byte to the reply's first
  /// Where the stored home position lies, steps: X and Y at the far end, Z at the plate.
  std::array<std::int32_t, 5> home{12667, 6756, 0, 0, 0};
  HeaterModel hotend{};
  HeaterModel bed{25, 125, 250, 120};
  std::vector<Fault> faults;
  std::uint64_t seed = 1;

  static MotionSettings replicator_motion() {
    MotionSettings m;
    m.steps_per_mm = {88.888889, 88.888889, 400, 96.2752018703};
    m.max_speed = {300, 300, 19.5, 26.6666667};
    m.max_acceleration = {1000, 1000, 150, 2000};
    m.print_acceleration = 2000;
    m.retract_acceleration = 2000;
    m.travel_acceleration = 2000;
    m.classic_jerk = true;
    m.jerk = {15, 15, 10, 20};
    m.min_segment_time_s = 0;
    m.sailfish = true;
    return m;
  }
};

}  // namespace voidpath::test::mock

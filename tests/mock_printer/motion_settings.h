#pragma once

#include <array>
#include <cstddef>

/// What the firmware of the mock knows about its machine. mm, mm/s, mm/s², axes in the order X Y Z E.
namespace voidpath::test::mock {

inline constexpr std::size_t kAxes = 4;
inline constexpr std::size_t kX = 0, kY = 1, kZ = 2, kE = 3;
inline constexpr char kAxisLetters[kAxes + 1] = "XYZE";
using Axes = std::array<double, kAxes>;

struct MotionSettings {
  Axes steps_per_mm{80, 80, 400, 93};
  Axes max_speed{500, 500, 10, 60};
  Axes max_acceleration{1500, 1500, 100, 5000};
  double print_acceleration = 1000;
  double retract_acceleration = 1500;
  double travel_acceleration = 1500;
  /// Corner rule: junction deviation, or the classic per-axis jerk.
  bool classic_jerk = false;
  double junction_deviation = 0.013;
  Axes jerk{8, 8, 0.4, 5};  ///< mm/s
  /// Sailfish's rules instead of Marlin's: corners, accelerations, no shortest move, no waiting for company.
  bool sailfish = false;
  double min_segment_time_s = 0.020;
  double min_speed = 0;         ///< mm/s, of moves that extrude
  double min_travel_speed = 0;  ///< mm/s
};

}  // namespace voidpath::test::mock

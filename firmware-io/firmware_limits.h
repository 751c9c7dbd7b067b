#pragma once

#include <array>
#include <optional>

namespace voidpath::fw {

/// One value for each axis, X, Y, Z, E; empty where the firmware did not say.
using PerAxis = std::array<std::optional<double>, 4>;

/// A box in the machine's frame, mm: X, Y, Z.
struct MachineBox {
  std::array<double, 3> min_mm{};
  std::array<double, 3> max_mm{};
  bool operator==(const MachineBox&) const = default;
};

/// The shortest form of a line that it is known to read, which is how it is sent.
enum class LineForm { plain, dense, packed };

/// How a firmware is set up, in its own words (M503, M211, M115). What it did not tell is empty; of several
/// extruders the first counts.
struct FirmwareLimits {
  PerAxis steps_per_mm;
  PerAxis max_feed_mm_s;
  PerAxis max_acceleration_mm_s2;
  PerAxis jerk_mm_s;  ///< of firmware with classic jerk
  std::optional<double> junction_deviation_mm;
  std::optional<double> print_acceleration_mm_s2;
  std::optional<double> retract_acceleration_mm_s2;
  std::optional<double> travel_acceleration_mm_s2;
  std::optional<double> min_feed_mm_s;
  std::optional<double> min_travel_feed_mm_s;
  std::optional<double> min_segment_time_s;
  std::optional<MachineBox> volume;  ///< M115's full area, else where the software endstops are
  LineForm line_form = LineForm::plain;

  bool operator==(const FirmwareLimits&) const = default;
};

}  // namespace voidpath::fw

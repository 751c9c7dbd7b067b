#pragma once

#include <array>
#include <string>

namespace voidpath::fw::s3g {

/// What the translation of G-code needs to know of a MakerBot. Axes X Y Z A B, or X Y Z. The values are a
/// Replicator 2's; X and Y home to their far ends, Z to its near one, on all of them.
struct Machine {
  std::array<double, 5> steps_per_mm = {88.888889, 88.888889, 400, 96.2752018703, 96.2752018703};
  std::array<double, 5> max_feed_mm_s = {300, 300, 19.5, 26.6666667, 26.6666667};
  std::array<double, 3> home_feed_mm_s = {41.6666667, 41.6666667, 18.3333333};
  int extruders = 1;
  bool heated_bed = false;
  int home_timeout_s = 20;
};

}  // namespace voidpath::fw::s3g

#include "engine/motion/sailfish.h"

#include <algorithm>
#include <cmath>

namespace voidpath::motion::sailfish {
namespace {

/// Share of the nominal speed at which the corner changes no axis by more than its jerk.
float corner_ratio(const AxisFloats& speed_v, const AxisFloats& jerk_v, const AxisFloats& before_v) {
  float ratio_r = 1;
  for (std::size_t i = 0; i < speed_v.size(); ++i) {
    if (std::abs(speed_v[i] - before_v[i]) <= jerk_v[i]) continue;
    if (speed_v[i] == 0) return 0;
    const float allowed_v = speed_v[i] > before_v[i] ? before_v[i] + jerk_v[i] : before_v[i] - jerk_v[i];
    ratio_r = std::min(ratio_r, allowed_v / speed_v[i]);
    if (ratio_r <= 0) return 0;
  }
  return ratio_r;
}

}  // namespace

float junction_v(const AxisFloats& speed_v, float nominal_v, const AxisFloats& jerk_v, bool joins,
                 AxisFloats& before_v) {
  const float least_jerk_v = *std::min_element(jerk_v.begin(), jerk_v.end());
  float ratio_r = 1;
  if (!joins) {
    ratio_r = std::min(1.0F, kMinPlannerV / nominal_v);
  } else if (nominal_v > least_jerk_v) {
    ratio_r = corner_ratio(speed_v, jerk_v, before_v);
  }
  for (std::size_t i = 0; i < speed_v.size(); ++i) before_v[i] = speed_v[i] * ratio_r;
  return std::max(nominal_v * ratio_r, std::min(kMinPlannerV, nominal_v));
}

}  // namespace voidpath::motion::sailfish

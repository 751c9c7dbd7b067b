#include "daemon/jobs/s3g_machine.h"

#include <algorithm>

namespace voidpath::daemon {

fw::s3g::Machine s3g_machine(const config::Profile& profile) {
  const motion::MachineLimits& limits = profile.limits;
  fw::s3g::Machine out;
  for (std::size_t i = 0; i < out.steps_per_mm.size(); ++i) {
    const std::size_t from = std::min<std::size_t>(i, 3);
    out.steps_per_mm[i] = limits.steps_per_mm[from];
    out.max_feed_mm_s[i] = limits.max_speed_mm_s[from];
  }
  for (std::size_t i = 0; i < 3; ++i) out.home_feed_mm_s[i] = limits.homing_speed_mm_s[i];
  out.extruders = profile.extruders;
  out.heated_bed = profile.heated_bed;
  return out;
}

}  // namespace voidpath::daemon

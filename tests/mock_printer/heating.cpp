#include "tests/mock_printer/heating.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::test::mock {
namespace {

constexpr double kResidency = 10;  ///< s to stay in the window
constexpr double kWindow = 1;      ///< °C around the target that starts the residency
constexpr double kHysteresis = 3;  ///< °C off the target that starts it anew
/// The firmware finds the window between two reports; half a report earlier on average, s.
constexpr double kFoundEarlier = 0.5;

}  // namespace

void GuardedHeater::set_target(double now, double target) {
  heater_.update(now);
  heater_.set_target(target);
  reached_ = heater_.temperature() >= heater_.target();
  watch_start_ = now;
  watch_goal_ = heater_.temperature() + guard_.watch_gain;
  below_since_ = -1;
}

std::optional<std::string> GuardedHeater::check(double now) {
  heater_.update(now);
  if (heater_.target() <= 0) return std::nullopt;
  const double gap = heater_.target() - heater_.temperature();
  if (gap <= 0) reached_ = true;
  if (!reached_) {
    // Close to the target there are no degrees left to gain; the runaway guard takes over there.
    if (heater_.temperature() >= watch_goal_ || gap <= guard_.watch_gain) {
      watch_start_ = now;
      watch_goal_ = heater_.temperature() + guard_.watch_gain;
    } else if (now - watch_start_ >= guard_.watch_s) {
      return "Heating failed";
    }
    if (gap > guard_.watch_gain) return std::nullopt;
  }
  if (gap <= guard_.runaway_gap) {
    below_since_ = -1;
  } else if (below_since_ < 0) {
    below_since_ = now;
  } else if (now - below_since_ >= guard_.runaway_s) {
    return "Thermal Runaway";
  }
  return std::nullopt;
}

bool HeatWait::over(double now, const Heater& heater) {
  if (heater.target() <= 0) return true;
  const double gap = heater.target() - heater.temperature();
  if (gap < 0 && !also_cooling_ && gap < -kHysteresis) return true;
  if (resident_since_ < 0) {
    if (std::abs(gap) < kWindow) resident_since_ = now - kFoundEarlier;
  } else if (std::abs(gap) > kHysteresis) {
    resident_since_ = -1;
  }
  return resident_since_ >= 0 && now >= done_at();
}

double HeatWait::done_at() const {
  return resident_since_ < 0 ? std::numeric_limits<double>::infinity() : resident_since_ + kResidency;
}

std::string HeatWait::countdown(double now) const {
  if (resident_since_ < 0) return " W:?";
  const double left = std::max(0.0, done_at() - now);
  return " W:" + std::to_string(static_cast<int>(left));
}

}  // namespace voidpath::test::mock

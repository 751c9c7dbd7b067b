#include "tests/mock_printer/thermal.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::test::mock {

void Heater::update(double now) {
  const double dt = now - time_;
  if (dt <= 0) return;
  time_ = now;
  const bool heats = !broken_ && target_ > temperature_;
  const double end = heats ? model_.full_power : model_.ambient;
  const double next = end + (temperature_ - end) * std::exp(-dt / model_.time_constant);
  if (heats)
    temperature_ = std::min(next, target_);
  else if (!broken_ && target_ > 0 && temperature_ >= target_)
    temperature_ = std::max(next, target_);
  else
    temperature_ = next;
}

void Heater::set_target(double target) { target_ = std::clamp(target, 0.0, model_.maximum); }

int Heater::power() const {
  if (target_ <= 0 || temperature_ > target_) return 0;
  constexpr double kFullDuty = 127;
  if (temperature_ < target_) return static_cast<int>(kFullDuty);
  const double share = (target_ - model_.ambient) / (model_.full_power - model_.ambient);
  return static_cast<int>(std::clamp(share, 0.0, 1.0) * kFullDuty);
}

double Heater::seconds_until(double temperature) const {
  const bool heats = !broken_ && target_ > temperature_;
  const double end = heats ? model_.full_power : model_.ambient;
  const double ratio = (temperature_ - end) / (temperature - end);
  if (!(ratio > 1)) return std::numeric_limits<double>::infinity();
  return model_.time_constant * std::log(ratio);
}

}  // namespace voidpath::test::mock

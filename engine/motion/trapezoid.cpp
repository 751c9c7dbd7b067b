#include "engine/motion/trapezoid.h"

#include <algorithm>
#include <cmath>

// Closed form of the stepper's recurrence.
//
// Accelerating, the rate of the next step is r' = r + a/r (the step lasted 1/r). With u = r²/(2a) that is
// u' = u + 1 + 1/(4u), and F(u) = u - ln(u)/4 + 1/(16u) grows by one a step up to terms of u⁻³. So after m
// steps F(u_m) = F(u_0) + m, solved by Newton, and the time is (r_m - r_0)/a. Decelerating, r' = r - a/r and
// G(u) = u + ln(u)/4 + 1/(16u) falls by one a step. Below kSeriesU the steps are taken one at a time.
// Rates are whole numbers: ⌊a·t⌋ is half a step/s below a·t on average, which the closed form subtracts.

namespace voidpath::motion {
namespace {

/// MINIMAL_STEP_RATE: the interrupt's timer would overflow below.
constexpr std::uint32_t kMinRate = 120;
/// From here on the series is exact to 0.001 steps over a whole ramp.
constexpr double kSeriesU = 4.0;
/// So few steps are quicker taken one at a time.
constexpr std::uint32_t kFewSteps = 6;
/// Mean of the fraction the integer rate drops.
constexpr double kMeanFraction = 0.5;

double up_invariant(double u) { return u - 0.25 * std::log(u) + 1 / (16 * u); }
double down_invariant(double u) { return u + 0.25 * std::log(u) + 1 / (16 * u); }

/// u with up_invariant(u) = value, for value ≥ kSeriesU.
double up_inverse(double value) {
  double u = value + 0.25 * std::log(value);
  u -= (up_invariant(u) - value) / (1 - 0.25 / u);
  return u;
}
/// u with down_invariant(u) = value.
double down_inverse(double value) {
  double u = std::max(value - 0.25 * std::log(value), 0.5 * kSeriesU);
  u -= (down_invariant(u) - value) / (1 + 0.25 / u);
  return u;
}

struct Ramp {
  double seconds;
  double rate;  ///< of its last step
};

/// The sum of 1/r over the first `count` steps of a recurrence is (last + its increment - first)/a: the rate
/// before the one that came out as `next`.
double rate_before(double next, double accel) { return (next + std::sqrt(next * next - 4 * accel)) / 2; }

/// `steps` steps from `initial` upwards, `elapsed` seconds after the block's start, not above `cap`.
Ramp ramp_up(double initial, double cap, double accel, double elapsed, std::uint32_t steps) {
  const double begun = elapsed;
  const double series_rate = std::sqrt(2 * accel * kSeriesU);
  double rate = initial;
  std::uint32_t left = steps;
  while (left > 0 && rate < cap) {
    rate = std::min(initial + std::floor(accel * elapsed), cap);
    if (rate >= series_rate && left > kFewSteps) break;
    elapsed += 1 / rate;
    --left;
  }
  const double first = initial - kMeanFraction + accel * elapsed;
  if (left > 0 && first < cap) {
    const double from = up_invariant(first * first / (2 * accel));
    const double below_cap = std::floor(up_invariant(cap * cap / (2 * accel)) - from) + 1;
    const double count = std::min(below_cap, static_cast<double>(left));
    const double next = std::sqrt(2 * accel * up_inverse(from + count));
    elapsed += (next - first) / accel;
    left -= static_cast<std::uint32_t>(count);
    rate = std::min(std::round(rate_before(next, accel)), cap);
  }
  if (left > 0) rate = cap;
  return {elapsed - begun + left / cap, rate};
}

/// `steps` steps from `reached` downwards, not below `least`.
double ramp_down(double reached, double least, double accel, std::uint32_t steps) {
  if (steps == 0) return 0;
  const double series_rate = std::max(least, std::sqrt(2 * accel * kSeriesU));
  double elapsed = 1 / reached;
  std::uint32_t left = steps - 1;
  const double first = reached + kMeanFraction - accel * elapsed;
  if (left > kFewSteps && first > series_rate) {
    const double from = down_invariant(first * first / (2 * accel));
    const double above = std::floor(from - down_invariant(series_rate * series_rate / (2 * accel))) + 1;
    const double count = std::min(above, static_cast<double>(left));
    const double next = std::sqrt(2 * accel * down_inverse(from - count));
    elapsed += (first - next) / accel;
    left -= static_cast<std::uint32_t>(count);
  }
  while (left > 0) {
    const double rate = reached - std::floor(accel * elapsed);
    if (rate <= least) break;
    elapsed += 1 / rate;
    --left;
  }
  return elapsed + left / least;
}

std::uint32_t rounded_up(float rate) {
  constexpr float kMost = 4e9F;  // fits 32 bits
  return std::max(kMinRate, static_cast<std::uint32_t>(std::min(std::ceil(rate), kMost)));
}

}  // namespace

StepProfile step_profile(const Block& block, float entry_v, float exit_v) {
  const float per_v = 1.0F / block.nominal_v;
  const auto nominal = static_cast<float>(block.nominal_rate);
  StepProfile out;
  out.steps = block.step_count;
  out.nominal_rate = block.nominal_rate;
  out.accel_steps = block.accel_steps;
  out.initial_rate = rounded_up(entry_v * per_v * nominal);
  out.final_rate = rounded_up(exit_v * per_v * nominal);
  const float half_inverse = 0.5F / static_cast<float>(block.accel_steps);
  const auto distance = [&](std::uint32_t rate) {
    const auto r = static_cast<float>(rate);
    return (nominal * nominal - r * r) * half_inverse;
  };
  const float up = distance(out.initial_rate);
  const float down = distance(out.final_rate);
  const auto steps = static_cast<double>(out.steps);
  double accelerate = std::ceil(static_cast<double>(up));
  double decelerate = std::floor(static_cast<double>(down));
  if (accelerate + decelerate > steps) {
    accelerate = std::ceil((static_cast<float>(out.steps) + up - down) * 0.5F);
    accelerate = std::clamp(accelerate, 0.0, steps);
    decelerate = steps - accelerate;
  }
  out.accelerate_until = static_cast<std::uint32_t>(std::max(0.0, accelerate));
  out.decelerate_after = static_cast<std::uint32_t>(std::clamp(steps - decelerate, 0.0, steps));
  return out;
}

double stepped_seconds(const StepProfile& p) {
  if (p.steps == 0) return 0;
  const std::uint32_t rest = p.steps - 1;
  const std::uint32_t up = std::min(p.accelerate_until, rest);
  const std::uint32_t cruise_end = std::max(std::min(p.decelerate_after, rest), up);
  const double accel = p.accel_steps;
  const double first = 1.0 / p.initial_rate;
  const Ramp ramp = up > 0 ? ramp_up(p.initial_rate, p.nominal_rate, accel, first, up)
                           : Ramp{0, static_cast<double>(p.initial_rate)};
  const double cruise = static_cast<double>(cruise_end - up) / p.nominal_rate;
  return first + ramp.seconds + cruise + ramp_down(ramp.rate, p.final_rate, accel, rest - cruise_end);
}

double stepped_seconds_by_loop(const StepProfile& p) {
  if (p.steps == 0) return 0;
  const double accel = p.accel_steps;
  double total = 1.0 / p.initial_rate;
  double slowing = 0;
  double reached = p.initial_rate;
  for (std::uint32_t n = 1; n < p.steps; ++n) {
    if (n <= p.accelerate_until) {
      reached = std::min<double>(p.initial_rate + std::floor(accel * total), p.nominal_rate);
      total += 1 / reached;
    } else if (n > p.decelerate_after) {
      const double lost = std::floor(accel * slowing);
      const double rate = lost < reached ? std::max<double>(reached - lost, p.final_rate) : p.final_rate;
      slowing += 1 / rate;
      total += 1 / rate;
    } else {
      total += 1.0 / p.nominal_rate;
    }
  }
  return total;
}

double ideal_seconds(double length_d, double entry_v, double nominal_v, double exit_v, double accel_a) {
  entry_v = std::min(entry_v, nominal_v);
  const double entry_v2 = entry_v * entry_v;
  const double gain_v2 = 2 * accel_a * length_d;
  exit_v = std::min({exit_v, nominal_v, std::sqrt(entry_v2 + gain_v2)});
  const double exit_v2 = exit_v * exit_v;
  if (entry_v2 - gain_v2 >= exit_v2) {  // brakes all the way, to the speed it can reach
    return 2 * length_d / (entry_v + std::sqrt(entry_v2 - gain_v2));
  }
  // Where up and down ramps meet: v² = (v₀² + v₁²)/2 + a·L.
  const double top_v = std::min(nominal_v, std::sqrt((entry_v2 + exit_v2 + gain_v2) / 2));
  const double ramps_d = (2 * top_v * top_v - entry_v2 - exit_v2) / (2 * accel_a);
  return (2 * top_v - entry_v - exit_v) / accel_a + std::max(0.0, length_d - ramps_d) / top_v;
}

double block_seconds(const Block& block, float entry_v, float exit_v, Stepping stepping) {
  if (stepping == Stepping::marlin_2_0) return stepped_seconds(step_profile(block, entry_v, exit_v));
  return ideal_seconds(block.length_d, entry_v, block.nominal_v, exit_v, block.accel_a);
}

}  // namespace voidpath::motion

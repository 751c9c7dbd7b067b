#include "engine/motion/planner.h"

#include "engine/motion/sailfish.h"
#include "engine/motion/trapezoid.h"

#include <algorithm>
#include <cmath>

namespace voidpath::motion {
namespace {

/// MIN_STEPS_PER_SEGMENT: shorter lines are left to the next one.
constexpr std::uint32_t kMinSteps = 6;
/// With fewer blocks than this the stepper waits for more, up to kFirstDelay_t (BLOCK_DELAY_FOR_1ST_MOVE).
constexpr std::size_t kStartCount = 3;
constexpr int kFirstDelayPolls = 100;
/// The stepper looks for work this often while idle.
constexpr double kPoll_t = 0.001;
/// Times closer than this are the same: rounding of a clock of hours.
constexpr double kSameTime_t = 1e-7;
/// Largest step position: differences of two still fit 32 bits.
constexpr float kMaxSteps = 1e9F;
/// Slowest feed that is obeyed; keeps durations finite on nonsense such as F1e-30. mm/s
constexpr float kLeastFeed_v = 1e-4F;
constexpr float kMostFeed_v = 1e6F;

bool is_sailfish(const MachineLimits& limits) { return limits.firmware == Firmware::s3g; }
std::uint32_t least_steps(const MachineLimits& limits) { return is_sailfish(limits) ? 1 : kMinSteps; }
std::size_t start_count(const MachineLimits& limits) { return is_sailfish(limits) ? 1 : kStartCount; }

std::int32_t to_step(float position_d, float steps_per_d) {
  const float steps = position_d * steps_per_d;
  if (std::isnan(steps)) return 0;
  return static_cast<std::int32_t>(std::lround(std::clamp(steps, -kMaxSteps, kMaxSteps)));
}

AxisFloats to_floats(const PerAxis& values) {
  AxisFloats out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(values[i]);
  return out;
}

void keep_positive(double& value, double old) {
  if (!(value > 0) || !(value < 1e9)) value = old;
}

}  // namespace

/// Signed travel of each axis, mm; turned into speeds once the block's speed is known.
struct Planner::AxisTravel {
  AxisFloats distance_d{};
  AxisFloats speed_v{};
};

Planner::Planner(const MachineLimits& limits, BlockListener* listener)
    : listener_(listener), queue_(std::clamp(limits.block_buffer, 2, 65536)) {
  set_limits(limits);
}

void Planner::set_limits(const MachineLimits& limits) {
  const MachineLimits old = limits_;
  limits_ = limits;
  for (std::size_t i = 0; i < kAxes; ++i) {
    keep_positive(limits_.steps_per_mm[i], old.steps_per_mm[i]);
    keep_positive(limits_.max_speed_mm_s[i], old.max_speed_mm_s[i]);
    keep_positive(limits_.max_acceleration_mm_s2[i], old.max_acceleration_mm_s2[i]);
  }
  keep_positive(limits_.print_acceleration_mm_s2, old.print_acceleration_mm_s2);
  keep_positive(limits_.retract_acceleration_mm_s2, old.retract_acceleration_mm_s2);
  keep_positive(limits_.travel_acceleration_mm_s2, old.travel_acceleration_mm_s2);
  keep_positive(limits_.junction_deviation_mm, old.junction_deviation_mm);

  max_v_ = to_floats(limits_.max_speed_mm_s);
  max_a_ = to_floats(limits_.max_acceleration_mm_s2);
  if (limits_.jerk_mm_s) jerk_v_ = to_floats(*limits_.jerk_mm_s);
  for (std::size_t i = 0; i < kAxes; ++i) {
    const auto scale = static_cast<float>(limits_.steps_per_mm[i]);
    if (steps_per_d_[i] > 0 && scale != steps_per_d_[i]) {  // M92: the same place in other steps
      position_[i] = to_step(static_cast<float>(position_[i]) * d_per_step_[i], scale);
    }
    steps_per_d_[i] = scale;
    d_per_step_[i] = 1.0F / scale;
    max_accel_steps_[i] = static_cast<std::uint32_t>(std::clamp(max_a_[i] * scale, 1.0F, 4e9F));
  }
}

std::array<std::int32_t, 4> Planner::to_steps(const AxisFloats& position_d) const {
  std::array<std::int32_t, 4> steps;
  for (std::size_t i = 0; i < kAxes; ++i) steps[i] = to_step(position_d[i], steps_per_d_[i]);
  return steps;
}

bool Planner::queue(const Move& move, const Chord& chord) {
  const std::array<std::int32_t, 4> target = to_steps(move.target_d);
  wait_for_slot();

  Block block;
  AxisTravel travel;
  block.tag = move.tag;
  block.safe_exit_v2 = chord.safe_exit_v2;
  float squares = 0;
  bool long_enough = false;
  for (std::size_t i = 0; i < kE; ++i) {
    const std::int32_t delta = target[i] - position_[i];
    block.steps[i] = static_cast<std::uint32_t>(std::abs(delta));
    travel.distance_d[i] = static_cast<float>(delta) * d_per_step_[i];
    squares += travel.distance_d[i] * travel.distance_d[i];
    long_enough = long_enough || block.steps[i] >= least_steps(limits_);
  }
  const float e_steps = static_cast<float>(target[kE] - position_[kE]) * flow_r_;
  block.steps[kE] = static_cast<std::uint32_t>(std::min(std::abs(e_steps) + 0.5F, 2 * kMaxSteps));
  block.e_d = travel.distance_d[kE] = e_steps * d_per_step_[kE];
  block.step_count = *std::max_element(block.steps.begin(), block.steps.end());
  if (block.step_count < least_steps(limits_)) return false;
  block.length_d = long_enough ? std::sqrt(squares) : std::abs(block.e_d);

  const bool moves_axes = block.steps[0] != 0 || block.steps[1] != 0 || block.steps[2] != 0;
  block.kind = !moves_axes                             ? MoveKind::filament
               : block.steps[kE] != 0 && block.e_d > 0 ? MoveKind::extrude
                                                       : MoveKind::travel;
  plan_speed(block, move.feed_v, travel);
  plan_acceleration(block);
  plan_junction(block, travel, chord.radius_d);
  position_ = target;
  enqueue(block);
  return true;
}

void Planner::plan_speed(Block& block, float feed_v, AxisTravel& travel) const {
  const double floor_v = block.steps[kE] != 0 ? limits_.min_speed_mm_s : limits_.min_travel_speed_mm_s;
  if (std::isnan(feed_v)) feed_v = 0;
  feed_v = std::clamp(std::max(feed_v, static_cast<float>(floor_v)), kLeastFeed_v, kMostFeed_v);
  const float per_d = 1.0F / block.length_d;
  float per_t = feed_v * per_d;

  // SLOWDOWN: while the buffer drains, lines shorter than the minimum segment time are stretched.
  const std::size_t waiting = queue_.waiting();
  if (waiting >= 2 && waiting + 1 <= static_cast<std::size_t>(limits_.block_buffer) / 2) {
    const double segment_us = std::round(1e6 / static_cast<double>(per_t));
    const double missing_us = limits_.min_segment_time_us - segment_us;
    if (missing_us > 0) {
      const double added_us = std::floor(2 * missing_us / static_cast<double>(waiting));
      per_t = static_cast<float>(1e6 / (segment_us + added_us));
    }
  }

  block.nominal_v = block.length_d * per_t;
  float rate = std::ceil(static_cast<float>(block.step_count) * per_t);
  float factor_r = 1;
  for (std::size_t i = 0; i < kAxes; ++i) {
    travel.speed_v[i] = travel.distance_d[i] * per_t;
    const float axis_v = std::abs(travel.speed_v[i]);
    if (axis_v > max_v_[i]) factor_r = std::min(factor_r, max_v_[i] / axis_v);
  }
  if (factor_r < 1) {
    for (float& v : travel.speed_v) v *= factor_r;
    rate = std::floor(rate * factor_r);
    block.nominal_v *= factor_r;
  }
  block.nominal_rate = static_cast<std::uint32_t>(std::clamp(rate, 1.0F, 4e9F));
}

void Planner::plan_acceleration(Block& block) const {
  const float steps_per_d = static_cast<float>(block.step_count) * (1.0F / block.length_d);
  const auto as_steps = [&](double accel) {
    return static_cast<std::uint32_t>(
        std::clamp(std::ceil(static_cast<float>(accel) * steps_per_d), 1.0F, 4e9F));
  };
  if (block.kind == MoveKind::filament) {
    block.accel_steps = as_steps(limits_.retract_acceleration_mm_s2);
  } else {
    std::uint32_t accel =
        as_steps(block.steps[kE] != 0 ? limits_.print_acceleration_mm_s2 : limits_.travel_acceleration_mm_s2);
    for (std::size_t i = 0; i < kAxes; ++i) {
      if (block.steps[i] == 0 || max_accel_steps_[i] >= accel) continue;
      const std::uint64_t most = std::uint64_t{max_accel_steps_[i]} * block.step_count / block.steps[i];
      if (is_sailfish(limits_)) {
        if (accel > most) accel = max_accel_steps_[i];
        continue;
      }
      accel = static_cast<std::uint32_t>(std::min<std::uint64_t>(accel, most));
    }
    block.accel_steps = std::max(accel, 1U);
  }
  block.accel_a = static_cast<float>(block.accel_steps) / steps_per_d;
}

void Planner::plan_junction(Block& block, const AxisTravel& travel, float radius_d) {
  // The first block after a stop, or a late one: it starts from rest.
  const bool joins = queue_.waiting() > 0 && last_.nominal_v > 0;
  if (is_sailfish(limits_) && limits_.jerk_mm_s) {
    const float v = sailfish::junction_v(travel.speed_v, block.nominal_v, jerk_v_, joins, last_.speed_v);
    block.max_entry_v2 = v * v;
    block.safe_exit_v2 = std::max(
        block.safe_exit_v2,
        std::min(sailfish::kMinPlannerV * sailfish::kMinPlannerV, block.nominal_v * block.nominal_v));
    last_.nominal_v = block.nominal_v;
    return;
  }
  if (limits_.jerk_mm_s) {
    const float safe_v = safe_speed(travel.speed_v, block.nominal_v, jerk_v_);
    const float v = joins ? jerk_junction_v(travel.speed_v, block.nominal_v, safe_v, last_, jerk_v_) : safe_v;
    block.max_entry_v2 = v * v;
    last_.safe_v = safe_v;
  } else {
    AxisFloats unit = travel.distance_d;
    if (block.steps[kE] != 0) {
      unit = normalized(unit);
    } else {
      for (float& x : unit) x *= 1.0F / block.length_d;
    }
    if (joins) {
      const DeviationParams params{block.accel_a, block.length_d,
                                   static_cast<float>(limits_.junction_deviation_mm), radius_d, max_a_};
      block.max_entry_v2 = std::min({junction_deviation_v2(unit, last_unit_, params),
                                     block.nominal_v * block.nominal_v, last_.nominal_v * last_.nominal_v});
    }
    last_unit_ = unit;
  }
  last_.speed_v = travel.speed_v;
  last_.nominal_v = block.nominal_v;
}

void Planner::enqueue(const Block& block) {
  if (queue_.empty()) first_queued_t_ = now_t_;
  queue_.push(block);
  if (queue_.count() == start_count(limits_)) ready_t_ = now_t_;
}

void Planner::set_position(Axis axis, float position_d) {
  const auto i = static_cast<std::size_t>(axis);
  position_[i] = to_step(position_d, steps_per_d_[i]);
  run_stepper(now_t_);
  if (queue_.empty()) return;
  wait_for_slot();
  Block block;
  block.sync = true;
  enqueue(block);
}

void Planner::reset_position(const AxisFloats& position_d) { position_ = to_steps(position_d); }

double Planner::next_event_t() const {
  if (queue_.busy()) return busy_end_t_;
  // The poll that ends the delay, or the first after there are blocks enough.
  const double ready_t =
      queue_.count() >= start_count(limits_) ? ready_t_ : first_queued_t_ + (kFirstDelayPolls - 1) * kPoll_t;
  return idle_from_t_ + (std::floor((ready_t - idle_from_t_) / kPoll_t) + 1) * kPoll_t;
}

void Planner::run_stepper(double until_t) {
  while (!queue_.empty()) {
    const double event_t = next_event_t();
    if (event_t > until_t) return;
    if (queue_.busy()) {
      queue_.pop();
      idle_from_t_ = event_t;
    }
    start_tail(event_t);
  }
}

void Planner::start_tail(double start_t) {
  while (!queue_.empty()) {
    queue_.take();
    const Block& block = queue_.tail();
    if (block.sync) {
      queue_.pop();
      continue;
    }
    const float entry_v = std::sqrt(block.entry_v2);
    const float exit_v = std::sqrt(queue_.tail_exit_v2());
    const double duration_t = block_seconds(block, entry_v, exit_v, limits_.stepping);
    busy_end_t_ = start_t + duration_t;
    if (listener_ != nullptr) listener_->on_block({&block, start_t, duration_t, entry_v, exit_v});
    return;
  }
  idle_from_t_ = start_t;
}

void Planner::wait_for_slot() {
  run_stepper(now_t_);
  while (queue_.full()) {
    now_t_ = std::max(now_t_, next_event_t());
    run_stepper(now_t_);
  }
}

bool Planner::plans_like(const Planner& other) const {
  return queue_.full() && now_t_ < busy_end_t_ &&
         std::abs((busy_end_t_ - now_t_) - (other.busy_end_t_ - other.now_t_)) < kSameTime_t &&
         queue_.same_plan(other.queue_);
}

void Planner::finish() {
  while (!queue_.empty()) {
    now_t_ = std::max(now_t_, next_event_t());
    run_stepper(now_t_);
  }
}

void Planner::dwell(double seconds) {
  finish();
  now_t_ += seconds;
}

void Planner::wait_until(double time_t) {
  now_t_ = std::max(now_t_, time_t);
  run_stepper(now_t_);
}

}  // namespace voidpath::motion

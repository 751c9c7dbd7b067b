#include "tests/mock_printer/planner.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace voidpath::test::mock {
namespace {

double square(double v) { return v * v; }

/// mm²/s² reachable within `length` from `speed2`.
double reachable2(double acceleration, double speed2, double length) {
  return speed2 + 2 * acceleration * length;
}

double dot(const Axes& a, const Axes& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kAxes; ++i) sum += a[i] * b[i];
  return sum;
}

Axes unit(Axes v) {
  const double norm = std::sqrt(dot(v, v));
  for (double& c : v) c /= norm;
  return v;
}

/// Steps to get from `from` to `to` steps/s (negative when that is against the acceleration's sign).
double ramp_steps(double from, double to, double acceleration) {
  return (square(to) - square(from)) / (2 * acceleration);
}

}  // namespace

Planner::Planner(const MotionSettings& settings, std::size_t ring)
    : settings_(settings), ring_(ring), shaped_exit_(ring, -1), shaped_entry_(ring, -1) {
  assert(ring >= 2);
}

Axes Planner::position() const {
  Axes mm;
  for (std::size_t i = 0; i < kAxes; ++i) mm[i] = steps_[i] / settings_.steps_per_mm[i];
  return mm;
}

void Planner::set_position(const Axes& position) {
  for (std::size_t i = 0; i < kAxes; ++i)
    steps_[i] = static_cast<std::int32_t>(std::lround(position[i] * settings_.steps_per_mm[i]));
  mark_position();
}

void Planner::set_e_position(double position) {
  steps_[kE] = static_cast<std::int32_t>(std::lround(position * settings_.steps_per_mm[kE]));
  mark_position();
}

void Planner::mark_position() {
  if (empty() || full()) return;  // a full ring cannot take the mark; the numbers alone carry it
  at(head_++) = Block{};
}

bool Planner::add_move(const Axes& target, double feed, double flow) {
  assert(!full());
  Block block;
  Axes mm{};
  bool long_enough = false, only_e = true;
  std::array<std::int32_t, kAxes> goal{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    goal[i] = static_cast<std::int32_t>(std::lround(target[i] * settings_.steps_per_mm[i]));
    const double wanted = goal[i] - steps_[i];
    const double scaled = i == kE ? wanted * flow : wanted;
    block.steps[i] = static_cast<std::int32_t>(std::lround(scaled));
    mm[i] = scaled / settings_.steps_per_mm[i];
    const std::int32_t count = std::abs(block.steps[i]);
    block.step_events = std::max(block.step_events, static_cast<std::uint32_t>(count));
    if (count >= (settings_.sailfish ? 1 : kMinStepsPerSegment)) {
      long_enough = true;
      if (i != kE) only_e = false;
    }
  }
  if (!long_enough) return false;
  block.length = only_e ? std::abs(mm[kE]) : std::hypot(mm[kX], mm[kY], mm[kZ]);

  Axes speed{};
  limit_speed(block, feed, mm, speed);
  limit_acceleration(block);
  Axes direction = mm;
  for (double& c : direction) c /= block.length;
  if (block.steps[kE] != 0) direction = unit(direction);
  const bool from_rest = head_ == nonbusy_ || previous_nominal_ == 0;
  block.max_entry_speed2 = settings_.sailfish       ? sailfish_speed2(block, speed, from_rest)
                           : settings_.classic_jerk ? jerk_speed2(block, speed, from_rest)
                                                    : junction_speed2(block, direction, from_rest);
  block.entry_speed2 = square(kMinimumPlannerSpeed);

  previous_direction_ = direction;
  if (!settings_.sailfish) previous_speed_ = speed;
  previous_nominal_ = block.nominal_speed;
  steps_ = goal;
  shaped_exit_[head_ % ring_.size()] = -1;
  at(head_++) = block;
  look_ahead();
  return true;
}

/// Sets nominal speed and rate and the speed of each axis, mm/s.
void Planner::limit_speed(Block& block, double feed, const Axes& mm, Axes& speed) const {
  // A feed of nothing would never end, one beyond this would leave the range of the rates, mm/s.
  constexpr double kFastest = 1e4;
  feed = std::clamp(feed, kMinimumPlannerSpeed, kFastest);
  feed = std::max(feed, block.steps[kE] != 0 ? settings_.min_speed : settings_.min_travel_speed);
  double per_second = feed / block.length;
  // A draining queue is stretched: a block shorter than the minimum time takes more of it the fewer wait.
  const std::uint64_t waiting = head_ - nonbusy_;
  if (waiting >= 2 && waiting <= ring_.size() / 2 - 1) {
    const double missing = settings_.min_segment_time_s - 1 / per_second;
    if (missing > 0) per_second = 1 / (1 / per_second + 2 * missing / static_cast<double>(waiting));
  }
  double factor = 1;
  for (std::size_t i = 0; i < kAxes; ++i) {
    speed[i] = mm[i] * per_second;
    if (std::abs(speed[i]) > settings_.max_speed[i])
      factor = std::min(factor, settings_.max_speed[i] / std::abs(speed[i]));
  }
  for (double& s : speed) s *= factor;
  block.nominal_speed = block.length * per_second * factor;
  const double rate = std::ceil(block.step_events * per_second);
  block.nominal_rate = std::max(1U, static_cast<std::uint32_t>(factor < 1 ? rate * factor : rate));
}

/// Acceleration in steps/s² of the dominant axis, so that no axis exceeds its own.
void Planner::limit_acceleration(Block& block) const {
  const double steps_per_mm = block.step_events / block.length;
  const bool moves_xyz = block.steps[kX] != 0 || block.steps[kY] != 0 || block.steps[kZ] != 0;
  const bool extrudes = block.steps[kE] != 0;
  const double wanted = !moves_xyz ? settings_.retract_acceleration
                        : extrudes ? settings_.print_acceleration
                                   : settings_.travel_acceleration;
  double rate = std::ceil(wanted * steps_per_mm);
  for (std::size_t i = 0; moves_xyz && i < kAxes; ++i) {
    if (block.steps[i] == 0) continue;
    const double axis_limit = std::floor(settings_.max_acceleration[i] * settings_.steps_per_mm[i]);
    const double allowed = std::floor(axis_limit * block.step_events / std::abs(block.steps[i]));
    if (settings_.sailfish) {
      if (rate > allowed) rate = axis_limit;
      continue;
    }
    rate = std::min(rate, allowed);
  }
  constexpr double kLeast = 1, kMost = 4e9;
  block.acceleration_rate = static_cast<std::uint32_t>(std::clamp(rate, kLeast, kMost));
  block.acceleration = block.acceleration_rate / steps_per_mm;
}

double Planner::acceleration_along(double limit, const Axes& direction) const {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double share = std::abs(direction[i]);
    if (limit * share > settings_.max_acceleration[i]) limit = settings_.max_acceleration[i] / share;
  }
  return limit;
}

double Planner::junction_speed2(const Block& block, const Axes& direction, bool from_rest) const {
  if (from_rest) return 0;
  // Cosine of the angle between the way back and the way on: −1 straight ahead, +1 reversal.
  const double cosine = -dot(previous_direction_, direction);
  // Closer to ±1 than this the firmware's single precision tells no more.
  constexpr double kStraight = 0.999999;
  double speed2 = square(kMinimumPlannerSpeed);
  if (cosine <= kStraight) {
    Axes turn{};
    for (std::size_t i = 0; i < kAxes; ++i) turn[i] = direction[i] - previous_direction_[i];
    const bool turns = dot(turn, turn) > 0;
    const double along = turns ? acceleration_along(block.acceleration, unit(turn)) : block.acceleration;
    const double c = std::max(cosine, -kStraight);
    const double sine_half = std::sqrt(0.5 * (1 - c));
    speed2 = along * settings_.junction_deviation * sine_half / (1 - sine_half);
    // Short and nearly straight: taken as a chord of an arc. mm, and the cosine of 135°.
    constexpr double kChord = 1.0, kCos135 = -0.7071067812;
    if (block.length < kChord && c < kCos135) speed2 = std::min(speed2, block.length * along / std::acos(-c));
  }
  return std::min({speed2, square(block.nominal_speed), square(previous_nominal_)});
}

double Planner::jerk_speed2(const Block& block, const Axes& speed, bool from_rest) {
  // The speed from which each axis may stop (or start) at once.
  double safe = block.nominal_speed;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double s = std::abs(speed[i]);
    if (s > settings_.jerk[i]) safe = std::min(safe, block.nominal_speed * settings_.jerk[i] / s);
  }
  double corner = safe;
  if (!from_rest) {
    // Both blocks pass the corner at one speed, at most the slower one's; the change of each axis is bounded.
    corner = std::min(block.nominal_speed, previous_nominal_);
    const double before = corner / previous_nominal_;
    double factor = 1;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double out = previous_speed_[i] * before * factor;
      const double in = speed[i] * factor;
      const bool reverses = (out > 0 && in < 0) || (out < 0 && in > 0);
      const double change = reverses ? std::max(std::abs(out), std::abs(in)) : std::abs(out - in);
      if (change > settings_.jerk[i]) factor *= settings_.jerk[i] / change;
    }
    corner *= factor;
    // Stopping and starting at the safe speeds may be faster than sharing one.
    constexpr double kPreferSafe = 0.99;
    if (previous_safe_speed_ > corner * kPreferSafe && safe > corner * kPreferSafe) corner = safe;
  }
  previous_safe_speed_ = safe;
  return square(corner);
}

/// Sailfish: each axis may change its speed by its jerk, between the speed at which the last corner was
/// passed and this block's; all axes give way by the same share.
double Planner::sailfish_speed2(const Block& block, const Axes& speed, bool from_rest) {
  const double gentlest = *std::min_element(settings_.jerk.begin(), settings_.jerk.end());
  double share = 1;
  if (from_rest) {
    share = std::min(1.0, kSailfishMinimumSpeed / block.nominal_speed);
  } else if (block.nominal_speed > gentlest) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double before = previous_speed_[i];
      const double highest = before + settings_.jerk[i], lowest = before - settings_.jerk[i];
      if (speed[i] >= lowest && speed[i] <= highest) continue;
      const double nearest = speed[i] > highest ? highest : lowest;
      share = std::min(share, speed[i] == 0 ? 0 : nearest / speed[i]);
    }
    share = std::max(share, 0.0);
  }
  for (std::size_t i = 0; i < kAxes; ++i) previous_speed_[i] = speed[i] * share;
  return square(std::max(block.nominal_speed * share, std::min(kSailfishMinimumSpeed, block.nominal_speed)));
}

void Planner::look_ahead() {
  // Backwards: the fastest entry from which a block can still slow down to the entry of its successor. The
  // first block that is not busy keeps its entry, since its predecessor already runs towards it.
  const double slowest = settings_.sailfish ? kSailfishMinimumSpeed : kMinimumPlannerSpeed;
  double exit2 = square(slowest);
  std::uint64_t first = nonbusy_;
  while (first < head_ && !at(first).is_move()) ++first;
  for (std::uint64_t seq = head_; seq-- > first + 1;) {
    Block& block = at(seq);
    if (!block.is_move()) continue;
    block.entry_speed2 =
        std::min(block.max_entry_speed2, reachable2(block.acceleration, exit2, block.length));
    exit2 = block.entry_speed2;
  }
  // Forwards: no faster than acceleration allows.
  const Block* previous = nullptr;
  for (std::uint64_t seq = first; seq < head_; ++seq) {
    Block& block = at(seq);
    if (!block.is_move()) continue;
    if (previous != nullptr)
      block.entry_speed2 = std::min(
          block.entry_speed2, reachable2(previous->acceleration, previous->entry_speed2, previous->length));
    previous = &block;
  }
  double exit_speed = slowest;
  for (std::uint64_t seq = head_; seq-- > first;) {
    if (!at(seq).is_move()) continue;
    shape(seq, exit_speed);
    exit_speed = std::sqrt(at(seq).entry_speed2);
  }
}

/// The trapezoid in steps, from the block's entry speed to `exit_speed` mm/s.
void Planner::shape(std::uint64_t seq, double exit_speed) {
  Block& block = at(seq);
  const std::size_t slot = seq % ring_.size();
  const double entry_speed = std::sqrt(block.entry_speed2);
  if (shaped_exit_[slot] == exit_speed && shaped_entry_[slot] == entry_speed) return;
  shaped_exit_[slot] = exit_speed;
  shaped_entry_[slot] = entry_speed;

  const double per_speed = block.nominal_rate / block.nominal_speed;
  const auto rate = [&](double speed) {
    return std::max(kMinimalRate, static_cast<std::uint32_t>(std::ceil(speed * per_speed)));
  };
  block.initial_rate = rate(entry_speed);
  block.final_rate = rate(exit_speed);
  const double a = block.acceleration_rate;
  const double count = block.step_events;
  double up = std::ceil(ramp_steps(block.initial_rate, block.nominal_rate, a));
  const double down = std::floor(ramp_steps(block.final_rate, block.nominal_rate, a));
  double level = count - up - down;
  if (level < 0) {  // never reaches nominal: where the two ramps cross
    const double cross =
        std::ceil((2 * a * count - square(block.initial_rate) + square(block.final_rate)) / (4 * a));
    up = std::clamp(cross, 0.0, count);
    level = 0;
  }
  // A nominal rate below the minimal one gives a negative ramp: then everything is cruise.
  up = std::max(up, 0.0);
  block.accelerate_until = static_cast<std::uint32_t>(up);
  block.decelerate_after = static_cast<std::uint32_t>(std::clamp(up + level, 0.0, 4e9));
}

const Block* Planner::take() {
  assert(nonbusy_ == tail_);
  while (tail_ < head_ && !at(tail_).is_move()) nonbusy_ = ++tail_;
  if (tail_ == head_) return nullptr;
  nonbusy_ = tail_ + 1;
  return &at(tail_);
}

void Planner::release() {
  assert(nonbusy_ == tail_ + 1);
  tail_ = nonbusy_;
}

void Planner::clear() {
  tail_ = nonbusy_ = head_;
  previous_nominal_ = 0;
}

double stepping_seconds(const Block& block) {
  const double a = block.acceleration_rate;
  const std::uint32_t count = block.step_events;
  double rate = block.initial_rate;
  double reached = rate;
  double t_up = 1 / rate, t_down = 0;
  double total = t_up;
  for (std::uint32_t n = 1; n < count; ++n) {
    if (n <= block.accelerate_until) {
      reached = std::min(block.initial_rate + std::floor(a * t_up), static_cast<double>(block.nominal_rate));
      const double dt = 1 / reached;
      t_up += dt;
      total += dt;
    } else if (n > block.decelerate_after) {
      const double lost = std::floor(a * t_down);
      rate = std::max(reached - lost, static_cast<double>(block.final_rate));
      const double dt = 1 / rate;
      t_down += dt;
      total += dt;
    } else {
      const std::uint32_t last = std::min(block.decelerate_after, count - 1);
      total += (last - n + 1) / static_cast<double>(block.nominal_rate);
      n = last;
    }
  }
  return total;
}

}  // namespace voidpath::test::mock

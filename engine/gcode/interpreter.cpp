#include "engine/gcode/interpreter.h"

#include <algorithm>
#include <cmath>

namespace voidpath::gcode {
namespace {

using motion::Axis;
using motion::MachineLimits;
using motion::PerAxis;

constexpr char kWords[] = {'X', 'Y', 'Z', 'E'};
constexpr float kInch_mm = 25.4F;
/// Far beyond any machine; keeps nonsense finite.
constexpr float kMostPosition_mm = 1e6F;
constexpr double kMostDwell_s = 1e6;
/// HOMING_BUMP_MM and HOMING_BUMP_DIVISOR of the firmware's default configuration.
constexpr double kBump_mm[] = {5, 5, 2};
constexpr double kBumpDivisor[] = {2, 2, 4};

void take(const Command& command, char word, double& value) {
  if (command.has(word) && command.get(word) > 0) value = static_cast<double>(command.get(word));
}
void take_axes(const Command& command, PerAxis& values, double unit) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (command.has(kWords[i]) && command.get(kWords[i]) > 0) {
      values[i] = static_cast<double>(command.get(kWords[i])) * unit;
    }
  }
}
bool is_motion(const Command& c) { return c.letter == 'G' && c.code >= 0 && c.code <= 3; }

}  // namespace

void Interpreter::note(const std::string& text) {
  if (std::find(notes_.begin(), notes_.end(), text) == notes_.end()) notes_.push_back(text);
}

Effect Interpreter::run(const Command& command, std::uint64_t tag) {
  switch (command.letter) {
    case 'G':
      return run_g(command, tag);
    case 'M':
      return run_m(command);
    default:
      return {};
  }
}

Effect Interpreter::run_g(const Command& command, std::uint64_t tag) {
  if (is_motion(command)) {
    return command.code < 2 ? line(command, tag) : arc(command, tag, command.code == 2);
  }
  switch (command.code) {
    case 4:
      return dwell(command);
    case 5:
      return line(command, tag);  // the chord: its curve is not followed
    case 10:
      return command.has_any("PLSX") ? Effect{} : retract(true, tag);
    case 11:
      return retract(false, tag);
    case 20:
      unit_mm_ = kInch_mm;
      break;
    case 21:
      unit_mm_ = 1;
      break;
    case 28:
      return home(command);
    case 29:
      planner_.finish();
      note("bed probing (G29) is not timed");
      break;
    case 90:
      relative_ = relative_e_ = false;
      break;
    case 91:
      relative_ = relative_e_ = true;
      break;
    case 92:
      if (command.subcode == 0) set_position(command);
      break;
    case 161:
    case 162:
      if (is_s3g()) return home_far(command);
      break;
    default:
      break;
  }
  return {};
}

Effect Interpreter::run_m(const Command& command) {
  switch (command.code) {
    case 0:
    case 1:
      note("waits for the user (M0, M1) are not timed");
      return command.has_any("PS") ? dwell(command) : (planner_.finish(), Effect{});
    case 82:
      relative_e_ = false;
      break;
    case 83:
      relative_e_ = true;
      break;
    case 92:
    case 201:
    case 203:
    case 204:
    case 205:
      set_limits(command);
      break;
    case 109:
    case 116:
    case 190:
    case 191: {
      planner_.finish();
      Effect effect;
      effect.kind = Effect::Kind::heating_wait;
      return effect;
    }
    case 207:
      if (command.has('S')) retract_d_ = std::abs(command.get('S')) * unit_mm_;
      if (command.get('F') > 0) retract_feed_mm_min_ = command.get('F') * unit_mm_;
      break;
    case 6:
    case 132:
    case 133:
    case 134:
      if (!is_s3g()) break;
      planner_.finish();
      if (command.code != 132) {
        Effect effect;
        effect.kind = Effect::Kind::heating_wait;
        return effect;
      }
      // The stored home: as far as anyone else knows the ends themselves.
      for (std::size_t i = 0; i < 3; ++i) position_[i] = static_cast<float>(end_mm(i));
      planner_.reset_position(position_);
      break;
    case 220:
      if (command.get('S') > 0) feed_percent_ = std::clamp(std::trunc(command.get('S')), 1.0F, 999.0F);
      break;
    case 221:
      if (command.has('S') && command.get('S') >= 0) planner_.set_flow(command.get('S') / 100);
      break;
    case 18:
    case 84:
    case 226:
    case 400:
    case 600:
      planner_.finish();
      break;
    default:
      break;
  }
  return {};
}

Interpreter::Axes Interpreter::target_of(const Command& command) {
  Axes target = position_;
  for (std::size_t i = 0; i < target.size(); ++i) {
    if (!command.has(kWords[i])) continue;
    const float value = command.get(kWords[i]) * unit_mm_;
    const bool relative = i == motion::kE ? relative_e_ : relative_;
    target[i] = std::clamp(relative ? position_[i] + value : value, -kMostPosition_mm, kMostPosition_mm);
  }
  if (command.get('F') > 0) feed_mm_min_ = command.get('F') * unit_mm_;
  return target;
}

Effect Interpreter::effect_of(const Axes& target) const {
  Effect effect;
  effect.moves_xy = target[0] != position_[0] || target[1] != position_[1];
  effect.flat = target[2] == position_[2];
  effect.moves_axes = effect.moves_xy || !effect.flat;
  effect.e_d = target[motion::kE] - position_[motion::kE];
  if (effect.moves_axes || effect.e_d != 0) effect.kind = Effect::Kind::move;
  return effect;
}

Effect Interpreter::finish_move(const Axes& target, Effect effect) {
  position_ = target;
  moved_ = moved_ || effect.kind == Effect::Kind::move;
  return effect;
}

Effect Interpreter::line(const Command& command, std::uint64_t tag) {
  const Axes target = target_of(command);
  const Effect effect = effect_of(target);
  planner_.line_to({target, feed_v(), tag});
  return finish_move(target, effect);
}

Effect Interpreter::arc(const Command& command, std::uint64_t tag, bool clockwise) {
  const Axes target = target_of(command);
  Effect effect = effect_of(target);
  motion::Arc arc{position_, target, 0, 0, clockwise, 0, feed_v(), tag};
  if (command.has('R')) {
    const auto center = motion::arc_center(position_, target, command.get('R') * unit_mm_, clockwise);
    if (!center) return {};  // the firmware reports bad parameters and stays
    arc.center_x_d = center->first;
    arc.center_y_d = center->second;
  } else if (command.has_any("IJ")) {
    arc.center_x_d = command.get('I') * unit_mm_;
    arc.center_y_d = command.get('J') * unit_mm_;
  } else {
    return {};
  }
  arc.extra_turns = static_cast<int>(std::clamp(command.get('P'), 0.0F, 1000.0F));
  effect.kind = Effect::Kind::move;
  effect.moves_axes = effect.moves_xy = true;
  planner_.arc_to(arc);
  return finish_move(target, effect);
}

Effect Interpreter::retract(bool back, std::uint64_t tag) {
  if (back == retracted_) return {};
  retracted_ = back;
  // The firmware moves the filament behind the file's back: afterwards E reads as before.
  Axes target = position_;
  target[motion::kE] += back ? -retract_d_ : retract_d_;
  const Effect effect = effect_of(target);
  planner_.line_to({target, retract_feed_mm_min_ / 60.0F, tag});
  planner_.set_position(Axis::e, position_[motion::kE]);
  return finish_move(position_, effect);
}

Effect Interpreter::dwell(const Command& command) {
  Effect effect;
  effect.kind = Effect::Kind::dwell;
  const double seconds =
      command.has('S') ? static_cast<double>(command.get('S')) : static_cast<double>(command.get('P')) / 1000;
  effect.seconds = std::clamp(seconds, 0.0, kMostDwell_s);
  planner_.dwell(effect.seconds);
  return effect;
}

Effect Interpreter::home(const Command& command) {
  const MachineLimits& limits = planner_.limits();
  Effect effect;
  effect.kind = Effect::Kind::homing;
  const bool all = !command.has_any("XYZ");
  for (std::size_t i = 0; i < 3; ++i) {
    if (!all && !command.has(kWords[i])) continue;
    // Where it stands at power-on nobody knows: half way on average.
    const double way_mm = known_[i] ? std::abs(static_cast<double>(position_[i])) : limits.travel_mm[i] / 2;
    const double speed = std::max(limits.homing_speed_mm_s[i], 0.1);
    effect.seconds += (way_mm + kBump_mm[i]) / speed + kBump_mm[i] * kBumpDivisor[i] / speed;
    known_[i] = true;
    position_[i] = 0;
  }
  planner_.finish();
  if (moved_) planner_.dwell(effect.seconds);
  planner_.reset_position(position_);
  return effect;
}

/// Where a MakerBot's switches stand: X and Y at the far end of a plate whose middle is 0, Z at the plate.
double Interpreter::end_mm(std::size_t axis) const {
  return axis < 2 ? planner_.limits().travel_mm[axis] / 2 : 0;
}

/// G161 and G162: the named axes run together until each has met its switch.
Effect Interpreter::home_far(const Command& command) {
  const MachineLimits& limits = planner_.limits();
  Effect effect;
  effect.kind = Effect::Kind::homing;
  double speed = command.get('F') > 0 ? static_cast<double>(command.get('F') * unit_mm_) / 60 : 1e9;
  double way_mm = 0, axes = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!command.has(kWords[i])) continue;
    ++axes;
    speed = std::min(speed, limits.homing_speed_mm_s[i]);
    const double way = known_[i] ? std::abs(end_mm(i) - static_cast<double>(position_[i])) : limits.travel_mm[i] / 2;
    way_mm = std::max(way_mm, way);
    known_[i] = true;
    position_[i] = static_cast<float>(end_mm(i));
  }
  effect.seconds = way_mm * std::sqrt(axes) / std::max(speed, 0.1);
  planner_.finish();
  if (moved_) planner_.dwell(effect.seconds);
  planner_.reset_position(position_);
  return effect;
}

void Interpreter::set_position(const Command& command) {
  for (std::size_t i = 0; i < position_.size(); ++i) {
    if (!command.has(kWords[i])) continue;
    const float value = std::clamp(command.get(kWords[i]) * unit_mm_, -kMostPosition_mm, kMostPosition_mm);
    if (std::abs(value - position_[i]) < 1e-6F) continue;  // nothing to rename, no queue slot
    position_[i] = value;
    planner_.set_position(static_cast<Axis>(i), value);
  }
}

void Interpreter::set_limits(const Command& command) {
  MachineLimits limits = planner_.limits();
  const auto unit = static_cast<double>(unit_mm_);
  switch (command.code) {
    case 92:
      take_axes(command, limits.steps_per_mm, 1 / unit);
      break;
    case 201:
      take_axes(command, limits.max_acceleration_mm_s2, unit);
      break;
    case 203:
      take_axes(command, limits.max_speed_mm_s, unit);
      break;
    case 204:
      take(command, 'S', limits.print_acceleration_mm_s2);
      take(command, 'S', limits.travel_acceleration_mm_s2);
      take(command, 'P', limits.print_acceleration_mm_s2);
      take(command, 'R', limits.retract_acceleration_mm_s2);
      take(command, 'T', limits.travel_acceleration_mm_s2);
      break;
    default:
      if (command.has('B')) limits.min_segment_time_us = static_cast<double>(command.get('B'));
      if (command.has('S')) limits.min_speed_mm_s = static_cast<double>(command.get('S'));
      if (command.has('T')) limits.min_travel_speed_mm_s = static_cast<double>(command.get('T'));
      // A firmware built for one corner rule ignores the other's words.
      if (limits.jerk_mm_s) {
        take_axes(command, *limits.jerk_mm_s, unit);
      } else if (const float j = command.get('J'); j >= 0.01F && j <= 0.3F) {
        limits.junction_deviation_mm = static_cast<double>(j);
      }
      break;
  }
  limits_changed_ = limits_changed_ || command.code != 92;
  planner_.set_limits(limits);
}

}  // namespace voidpath::gcode

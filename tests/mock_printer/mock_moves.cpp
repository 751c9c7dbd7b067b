// Commands that move the machine or say where it is.

#include "tests/mock_printer/mock_marlin.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::test::mock {
namespace {

constexpr double kSecondsPerMinute = 60;
/// Positions end here, so that steps stay far within 32 bits, mm.
constexpr double kFarthest = 1e5;

}  // namespace

bool MockMarlin::execute_motion(const Command& c) {
  if (c.letter() == 'T') return true;
  if (c.letter() != 'G') {
    if (c.is('M', 400)) {
      after_drain({});
      return true;
    }
    if (c.is('M', 410)) {
      quick_stop();
      return true;
    }
    return false;
  }
  switch (c.code()) {
    case 0:
    case 1:
      move(c);
      return true;
    case 2:
      arc(c, true);
      return true;
    case 3:
      arc(c, false);
      return true;
    case 4:
      after_drain({});
      tasks_.push_back({.kind = Task::Kind::kDwell,
                        .seconds = c.has('S') ? c.value_or('S', 0) : c.value_or('P', 0) / 1000,
                        .account = &totals_.dwell_s});
      return true;
    case 17:
    case 18:
    case 19:
    case 21:
      return true;
    case 28:
      home(c);
      return true;
    case 29:
      after_drain({});
      tasks_.push_back({.kind = Task::Kind::kDwell, .seconds = options_.leveling_s});
      return true;
    case 90:
      relative_ = relative_e_ = false;
      return true;
    case 91:
      relative_ = relative_e_ = true;
      return true;
    case 92:
      set_position(c);
      return true;
    default:
      return false;
  }
}

Axes MockMarlin::target_of(const Command& c) {
  Axes target = position_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const auto v = c.value(kAxisLetters[i]);
    if (!v) continue;
    const bool relative = i == kE ? relative_e_ : relative_;
    target[i] = relative ? position_[i] + *v : *v;
    const double reach = i == kE ? kFarthest : options_.reach_mm;
    target[i] = std::clamp(target[i], -reach, reach);
  }
  if (const auto f = c.value('F'); f && *f > 0) feed_ = *f / kSecondsPerMinute;
  return target;
}

void MockMarlin::queue_move(Axes target) { tasks_.push_back({.kind = Task::Kind::kMove, .target = target}); }

void MockMarlin::move(const Command& c) {
  const Axes target = target_of(c);
  hotend_.heater().update(now_);
  if (options_.dialect.refuses) {
    const bool travels = !std::equal(target.begin(), target.begin() + kE, position_.begin());
    if (travels && !homed_)
      return refuse_command("Must home axis first: " + fixed(target[kX], 3) + " " + fixed(target[kY], 3) +
                            " " + fixed(target[kZ], 3) + " [" + fixed(target[kE], 3) + "]");
    if (target[kE] != position_[kE] && !cold_allowed_ &&
        hotend().temperature() < options_.min_extrusion_temperature) {
      write_line("// Extrude below minimum temp");
      write_line("// See the 'min_extrude_temp' config option for details");
      return refuse_command("Extrude below minimum temp");
    }
  }
  if (target[kE] != position_[kE] && !cold_allowed_ &&
      hotend().temperature() < options_.min_extrusion_temperature) {
    write_line("echo: cold extrusion prevented");
    position_[kE] = target[kE];
    motion_.set_e_position(position_[kE]);
  } else if (std::abs(target[kE] - position_[kE]) > options_.max_extrusion_mm) {
    write_line("echo: too long extrusion prevented");
    position_[kE] = target[kE];
    motion_.set_e_position(position_[kE]);
  }
  segment_feed_ = feed_mm_s();
  position_ = target;
  queue_move(target);
}

/// G2 and G3 as chords, in the XY plane; Z and E in proportion to the angle.
void MockMarlin::arc(const Command& c, bool clockwise) {
  const Axes from = position_;
  const Axes to = target_of(c);
  double i = c.value_or('I', 0), j = c.value_or('J', 0);
  if (const auto r = c.value('R')) {
    const double dx = to[kX] - from[kX], dy = to[kY] - from[kY], d = std::hypot(dx, dy);
    const double inside = *r * *r - d * d / 4;
    if (d == 0 || inside < 0) return;
    const double h = std::sqrt(inside) * (clockwise == (*r > 0) ? -1 : 1);
    i = dx / 2 - h * dy / d;
    j = dy / 2 + h * dx / d;
  }
  const double radius = std::hypot(i, j);
  if (radius == 0) {
    write_line("echo:Bad arc");
    return;
  }
  constexpr double kTurn = 2 * std::numbers::pi;
  const double start = std::atan2(-j, -i);
  double sweep = std::atan2(to[kY] - from[kY] - j, to[kX] - from[kX] - i) - start;
  // Ending where it starts is a full turn. rad; far below what a step resolves.
  constexpr double kNoTurn = 1e-6;
  sweep = std::remainder(sweep, kTurn);
  if (std::abs(sweep) < kNoTurn) sweep = 0;
  if (clockwise && sweep >= 0) sweep -= kTurn;
  if (!clockwise && sweep <= 0) sweep += kTurn;
  // Chords of at most 1 mm, at least 72 to a full turn, none shorter than 0.1 mm.
  constexpr double kLongest = 1.0, kShortest = 0.1, kPerTurn = 72;
  const double length = std::abs(sweep) * radius;
  const double wanted = std::max(length / kLongest, kPerTurn * std::abs(sweep) / kTurn);
  const int count = std::max(1, static_cast<int>(std::ceil(std::min(wanted, length / kShortest))));
  segment_feed_ = feed_mm_s();
  for (int n = 1; n < count; ++n) {
    const double share = static_cast<double>(n) / count;
    const double angle = start + sweep * share;
    Axes p;
    for (std::size_t a = 0; a < kAxes; ++a) p[a] = from[a] + (to[a] - from[a]) * share;
    p[kX] = from[kX] + i + radius * std::cos(angle);
    p[kY] = from[kY] + j + radius * std::sin(angle);
    queue_move(p);
  }
  queue_move(to);
  position_ = to;
}

void MockMarlin::home(const Command& c) {
  const bool all = !c.has('X') && !c.has('Y') && !c.has('Z');
  double seconds = 0;
  std::array<bool, 3> homed{};
  for (std::size_t i = 0; i < 3; ++i) {
    homed[i] = all || c.has(kAxisLetters[i]);
    if (!homed[i]) continue;
    const double speed = std::min(options_.homing_speed_mm_s, motion_.settings().max_speed[i]);
    constexpr double kBumps = 1.0;  // the second, slow approach, s
    seconds += std::abs(position_[i]) / speed + kBumps;
  }
  after_drain({});
  tasks_.push_back({.kind = Task::Kind::kDwell, .seconds = seconds, .account = &totals_.homing_s});
  tasks_.push_back({.kind = Task::Kind::kCall, .action = [this, homed, all] {
                      homed_ = homed_ || all;
                      for (std::size_t i = 0; i < 3; ++i)
                        if (homed[i]) position_[i] = 0;
                      motion_.set_position(position_);
                      motion_.align_steps();
                      report_position();
                    }});
}

void MockMarlin::set_position(const Command& c) {
  bool xyz = false, any = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const auto v = c.value(kAxisLetters[i]);
    if (!v) continue;
    any = true;
    xyz = xyz || i != kE;
    position_[i] = std::clamp(*v, -kFarthest, kFarthest);
  }
  if (!any) {
    position_ = {};
    xyz = true;
  }
  if (xyz)
    motion_.set_position(position_);
  else
    motion_.set_e_position(position_[kE]);
  report_position();
}

void MockMarlin::after_drain(std::function<void()> action) {
  tasks_.push_back({.kind = Task::Kind::kDrained});
  if (action) tasks_.push_back({.kind = Task::Kind::kCall, .action = std::move(action)});
}

void MockMarlin::report_position() {
  std::string line;
  for (std::size_t i = 0; i < kAxes; ++i)
    line += std::string(i ? " " : "") + kAxisLetters[i] + ":" + fixed(position_[i], 2);
  line += " Count";
  const auto steps = motion_.steps_at(now_);
  for (std::size_t i = 0; i < 3; ++i) line += std::string(" ") + kAxisLetters[i] + ":" + fixed(steps[i], 0);
  write_line(line);
}

}  // namespace voidpath::test::mock

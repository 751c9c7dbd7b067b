// Moves, homing, positions.
#include "firmware-io/s3g/encoder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace voidpath::fw::s3g {
namespace {

constexpr std::uint8_t kXyz = 0x07;
constexpr std::uint8_t kExtruders = 0x18;
/// Further than any machine reaches, mm; its steps fit 31 bits.
constexpr double kFarthest_mm = 10000;
/// Farthest that a chord may lie from its arc, mm: the motors' own step, and the serial line can still feed
/// it.
constexpr double kChordError_mm = 0.01;
constexpr double kLeastChord_mm = 0.2;
/// An arc whose ends lie this much apart in radius is none, mm.
constexpr double kRadiusError_mm = 0.5;
constexpr double kSecond_us = 1e6;

struct Travel {
  std::array<double, kAxes> mm{};
  double distance_mm = 0;  ///< of X, Y, Z; of the extruder where nothing else moves
  std::int32_t most_steps = 0;
};

Travel travel_between(const Stand& from, const Stand& to, const Machine& machine) {
  Travel out;
  double squares = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const std::int32_t steps = to.steps[i] - from.steps[i];
    out.mm[i] = std::abs(steps / machine.steps_per_mm[i]);
    out.most_steps = std::max(out.most_steps, std::abs(steps));
    if (i < 3) squares += out.mm[i] * out.mm[i];
  }
  out.distance_mm = squares > 0 ? std::sqrt(squares) : std::max(out.mm[kA], out.mm[kB]);
  return out;
}

double to_range(double mm) {
  if (std::abs(mm) > kFarthest_mm) throw EncodeError("a position no printer reaches");
  return mm;
}

}  // namespace

Encoder::Vec3 Encoder::target_of(const Words& words) {
  Vec3 target = state_.position_mm;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!words.has(kAxisLetters[i])) continue;
    const double value = words.get(kAxisLetters[i]) * state_.unit_mm;
    if (state_.relative && (state_.stand.known & bit_of(i)) == 0) {
      throw EncodeError(std::string("a relative move from nobody knows where: say where ") + kAxisLetters[i] +
                        " stands first, by G92 or an absolute move");
    }
    target[i] = to_range(state_.relative ? state_.position_mm[i] + value : value);
  }
  if (words.get('F') > 0) state_.feed_mm_s = words.get('F') * state_.unit_mm / 60;
  return target;
}

// Forward millimetres of A and B; the logical positions follow.
std::array<double, 2> Encoder::extrusion_of(const Words& words) {
  std::array<double, 2> out{};
  const auto take = [&](char word, std::size_t tool) {
    if (!words.has(word)) return;
    const double value = to_range(words.get(word) * state_.unit_mm);
    const double mm = state_.relative_e ? value : value - state_.extruder_mm[tool];
    if (mm != 0 && tool >= static_cast<std::size_t>(machine_.extruders)) {
      throw EncodeError("this printer has no second extruder");
    }
    state_.extruder_mm[tool] += mm;
    out[tool] += mm;
  };
  take('A', 0);
  take('B', 1);
  take('E', static_cast<std::size_t>(state_.tool));
  return out;
}

void Encoder::line_to(const Words& words) {
  const Vec3 target = target_of(words);
  const auto extrusion = extrusion_of(words);
  move_to(target, extrusion, axes_of(words, 0) & kXyz);
}

void Encoder::move_to(const Vec3& target, std::array<double, 2> extrusion, std::uint8_t named) {
  Stand to = state_.stand;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((named & bit_of(i)) == 0) continue;
    to.steps[i] = static_cast<std::int32_t>(std::lround(target[i] * machine_.steps_per_mm[i]));
  }
  std::array<double, 2> remainder{};
  for (std::size_t tool = 0; tool < 2; ++tool) {
    const double exact =
        extrusion[tool] * state_.flow_ratio * machine_.steps_per_mm[kA + tool] + state_.remainder[tool];
    const long whole = std::lround(exact);
    remainder[tool] = exact - static_cast<double>(whole);
    to.steps[kA + tool] = static_cast<std::int32_t>(
        std::clamp<std::int64_t>(std::int64_t{to.steps[kA + tool]} - whole, -2'000'000'000, 2'000'000'000));
  }
  if ((named & ~state_.stand.known) != 0) {
    to.known = static_cast<std::uint8_t>(to.known | named);
    if ((to.known & kXyz) != kXyz) {
      throw EncodeError("a move while nobody knows where all axes stand: name X, Y and Z, or use G92 first");
    }
    if (to.steps[kA] != state_.stand.steps[kA] || to.steps[kB] != state_.stand.steps[kB]) {
      throw EncodeError("extruding on the way from nobody knows where");
    }
    move_unknown(to);
  } else if (to.steps != state_.stand.steps) {
    send_move(to);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if ((named & bit_of(i)) != 0) state_.position_mm[i] = target[i];
  }
  state_.remainder = remainder;
}

// 155, accelerated by the firmware.
void Encoder::send_move(const Stand& to) {
  tell_tool();
  const Travel travel = travel_between(state_.stand, to, machine_);
  double feed_mm_s = state_.feed_mm_s * state_.speed_ratio;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (travel.mm[i] > 0) {
      feed_mm_s = std::min(feed_mm_s, machine_.max_feed_mm_s[i] * travel.distance_mm / travel.mm[i]);
    }
  }
  const double rate = travel.most_steps * feed_mm_s / travel.distance_mm;  // steps/s of the longest axis
  constexpr double kMostSpeed = 65535;
  const auto speed_64 = static_cast<std::uint16_t>(std::clamp(std::floor(feed_mm_s * 64), 1.0, kMostSpeed));
  Payload payload(Command::move);
  std::uint8_t relative = kExtruders;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool absolute = i < 3 && (state_.stand.known & bit_of(i)) != 0;
    if (i < 3 && !absolute) relative = static_cast<std::uint8_t>(relative | bit_of(i));
    payload.i32(absolute ? to.steps[i] : to.steps[i] - state_.stand.steps[i]);
  }
  payload.u32(static_cast<std::uint32_t>(std::clamp(rate, 1.0, 4e9)))
      .u8(relative)
      .f32(static_cast<float>(travel.distance_mm))
      .u16(speed_64);
  act(payload, Action::Kind::move);
  state_.stand = to;
  out_.actions.back().after = to;
}

// 139: to an absolute place in whole, each step after the same time, which suits the slowest axis.
void Encoder::move_unknown(const Stand& to) {
  tell_tool();
  const double feed_mm_s = state_.feed_mm_s * state_.speed_ratio;
  double step_us = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double axis_feed = std::min(feed_mm_s, machine_.max_feed_mm_s[i]);
    if (to.steps[i] == state_.stand.steps[i] && (state_.stand.known & bit_of(i)) != 0) continue;
    step_us = std::max(step_us, kSecond_us / (machine_.steps_per_mm[i] * axis_feed));
  }
  if (step_us <= 0)
    step_us = kSecond_us / (machine_.steps_per_mm[kX] * std::min(feed_mm_s, machine_.max_feed_mm_s[kX]));
  Payload payload(Command::move_steps);
  for (std::size_t i = 0; i < kAxes; ++i) payload.i32(to.steps[i]);
  payload.u32(static_cast<std::uint32_t>(std::clamp(std::round(step_us), 1.0, 1e6)));
  act(payload, Action::Kind::move);
  state_.stand = to;
  out_.actions.back().after = to;
}

void Encoder::arc_to(const Words& words, bool clockwise) {
  if ((state_.stand.known & kXyz) != kXyz) throw EncodeError("an arc from nobody knows where");
  const Vec3 from = state_.position_mm;
  const Vec3 to = target_of(words);
  const double dx = to[kX] - from[kX], dy = to[kY] - from[kY];
  double i = words.get('I') * state_.unit_mm, j = words.get('J') * state_.unit_mm;
  if (words.has('R')) {
    const double r = words.get('R') * state_.unit_mm;
    const double chord = std::hypot(dx, dy);
    if (chord == 0 || std::abs(r) < chord / 2 - kRadiusError_mm) throw EncodeError("no arc has this radius");
    const double off = std::sqrt(std::max(0.0, r * r - chord * chord / 4));
    const double side = clockwise != (r < 0) ? -1.0 : 1.0;
    i = dx / 2 - side * off * dy / chord;
    j = dy / 2 + side * off * dx / chord;
  } else if (!words.has_any("IJ")) {
    throw EncodeError("an arc without centre or radius");
  }
  const double radius = std::hypot(i, j);
  if (radius == 0 || std::abs(std::hypot(dx - i, dy - j) - radius) > kRadiusError_mm) {
    throw EncodeError("an arc whose ends lie at different distances from its centre");
  }
  const double begin = std::atan2(-j, -i);
  double sweep = std::atan2(dy - j, dx - i) - begin;
  const double turn = 2 * std::numbers::pi;
  if (clockwise) {
    while (sweep >= -1e-9) sweep -= turn;
  } else {
    while (sweep <= 1e-9) sweep += turn;
  }
  const auto extrusion = extrusion_of(words);
  // A chord over the angle a lies r(1 - cos(a/2)) inside its arc.
  const double widest = 2 * std::acos(std::max(1 - kChordError_mm / radius, -1.0));
  const double by_error = std::ceil(std::abs(sweep) / std::max(widest, kLeastChord_mm / radius));
  const auto chords = static_cast<int>(std::clamp(by_error, 1.0, 10000.0));
  for (int n = 1; n <= chords; ++n) {
    const double share = static_cast<double>(n) / chords;
    const double angle = begin + sweep * share;
    Vec3 at = {from[kX] + i + radius * std::cos(angle), from[kY] + j + radius * std::sin(angle),
               from[kZ] + (to[kZ] - from[kZ]) * share};
    if (n == chords) at = to;
    move_to(at, {extrusion[0] / chords, extrusion[1] / chords}, kXyz);
  }
}

void Encoder::home(const Words& words, bool to_max) {
  const auto axes = static_cast<std::uint8_t>(axes_of(words, 0) & kXyz);
  if (axes == 0) throw EncodeError("homing without saying which axes");
  constexpr auto kPlane = static_cast<std::uint8_t>(bit_of(kX) | bit_of(kY));
  // The wrong way they grind against the frame.
  if ((to_max && (axes & bit_of(kZ)) != 0) || (!to_max && (axes & kPlane) != 0)) {
    throw EncodeError("X and Y have their switches at the far end (G162), Z at the near one (G161)");
  }
  home_axes(axes, to_max, words.has('F') ? words.get('F') * state_.unit_mm / 60 : 1e9);
}

void Encoder::home_axes(std::uint8_t axes, bool to_max, double feed_mm_s) {
  if (axes == 0) return;
  double most_steps_per_mm = 0;
  int count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((axes & bit_of(i)) == 0) continue;
    ++count;
    feed_mm_s = std::min(feed_mm_s, machine_.home_feed_mm_s[i]);
    most_steps_per_mm = std::max(most_steps_per_mm, machine_.steps_per_mm[i]);
  }
  if (!(feed_mm_s > 0)) throw EncodeError("homing at no speed");
  // The diagonal of so many axes at that feed.
  const double step_us = std::round(std::sqrt(count) / feed_mm_s * kSecond_us / most_steps_per_mm);
  tell_tool();
  act(Payload(to_max ? Command::home_max : Command::home_min)
          .u8(axes)
          .u32(static_cast<std::uint32_t>(std::clamp(step_us, 1.0, 1e7)))
          .u16(static_cast<std::uint16_t>(machine_.home_timeout_s)),
      Action::Kind::home);
  state_.stand.known = static_cast<std::uint8_t>(state_.stand.known & ~axes);
  out_.actions.back().after = state_.stand;
}

void Encoder::set_position(const Words& words) {
  const bool nothing_named = !words.has_any("XYZABE");
  const auto named = nothing_named ? kXyz : static_cast<std::uint8_t>(axes_of(words, 0) & kXyz);
  const auto value = [&](char word) { return to_range(words.get(word) * state_.unit_mm); };
  // Filament is moved relative: renaming its place is the host's business alone, but for the letters of
  // motors.
  if (words.has('E') || nothing_named) state_.extruder_mm[static_cast<std::size_t>(state_.tool)] = value('E');
  if (words.has('A')) state_.extruder_mm[0] = value('A');
  if (words.has('B')) state_.extruder_mm[1] = value('B');
  if (named == 0 && !words.has_any("AB")) return;
  Stand to = state_.stand;
  to.known = static_cast<std::uint8_t>(to.known | named);
  if ((to.known & kXyz) != kXyz) {
    throw EncodeError("G92 for some axes while nobody knows where the others stand: name X, Y and Z");
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if ((named & bit_of(i)) == 0) continue;
    state_.position_mm[i] = value(kAxisLetters[i]);
    to.steps[i] = static_cast<std::int32_t>(std::lround(state_.position_mm[i] * machine_.steps_per_mm[i]));
  }
  for (const std::size_t i : {kA, kB}) {
    if (words.has(kAxisLetters[i])) {
      to.steps[i] =
          static_cast<std::int32_t>(-std::lround(value(kAxisLetters[i]) * machine_.steps_per_mm[i]));
    }
  }
  tell_tool();
  Payload payload(Command::set_position);
  for (const std::int32_t steps : to.steps) payload.i32(steps);
  act(payload);
  state_.stand = to;
  out_.actions.back().after = to;
}

}  // namespace voidpath::fw::s3g

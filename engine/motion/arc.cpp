#include "engine/motion/arc.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::motion {
namespace {

constexpr float kTurn = 2 * std::numbers::pi_v<float>;
constexpr float kMinChord_d = 0.1F;
constexpr float kMaxChord_d = 1.0F;
constexpr float kChordsATurn = 72;
/// End points nearer than this are the same: a full turn. mm
constexpr float kSamePoint_d = 1e-6F;
/// More chords than any real arc has; bounds the work on nonsense input.
constexpr float kMostChords = 65535;
constexpr int kMostTurns = 1000;

struct Sweep {
  float angle = 0;  ///< signed, counter-clockwise positive
  float least_chords = 1;
};

Sweep sweep_of(const Arc& arc) {
  const float dx = arc.to_d[0] - arc.from_d[0];
  const float dy = arc.to_d[1] - arc.from_d[1];
  const float turns = static_cast<float>(std::clamp(arc.extra_turns, 0, kMostTurns));
  const float sign = arc.clockwise ? -1.0F : 1.0F;
  Sweep sweep;
  if (std::abs(dx) < kSamePoint_d && std::abs(dy) < kSamePoint_d) {
    sweep.angle = sign * kTurn;
  } else {
    const float ax = -arc.center_x_d;  // centre to start
    const float ay = -arc.center_y_d;
    const float bx = dx + ax;  // centre to end
    const float by = dy + ay;
    sweep.angle = std::atan2(ax * by - ay * bx, ax * bx + ay * by);
    if (sweep.angle * sign < 0) sweep.angle += sign * kTurn;
  }
  sweep.least_chords = std::ceil(kChordsATurn * std::abs(sweep.angle) / kTurn);
  sweep.angle += sign * turns * kTurn;
  sweep.least_chords += turns * kChordsATurn;
  return sweep;
}

float chord_count(float arc_d, float least) {
  const float nominal = std::max({std::floor(arc_d / kMaxChord_d), least, 1.0F});
  const float chord_d = arc_d / nominal;
  float count = nominal;
  if (chord_d > kMaxChord_d) count = std::ceil(arc_d / kMaxChord_d);
  if (chord_d < kMinChord_d) count = std::max(1.0F, std::floor(arc_d / kMinChord_d));
  return std::min(count, kMostChords);
}

}  // namespace

std::optional<std::pair<float, float>> arc_center(const AxisFloats& from_d, const AxisFloats& to_d,
                                                  float radius_d, bool clockwise) {
  const float dx = to_d[0] - from_d[0];
  const float dy = to_d[1] - from_d[1];
  const float apart_d = std::hypot(dx, dy);
  if (!(apart_d > 0) || radius_d == 0) return std::nullopt;
  // From the middle of the chord across it, to the side that the turn and the sign of the radius ask for.
  const float side = clockwise != (radius_d < 0) ? -1.0F : 1.0F;
  const float half_d = 0.5F * apart_d;
  const float off_d = std::sqrt(std::max(0.0F, radius_d * radius_d - half_d * half_d));
  return std::pair{0.5F * dx - side * off_d * dy / apart_d, 0.5F * dy + side * off_d * dx / apart_d};
}

void cut_arc(const Arc& arc, const MachineLimits& limits,
             const std::function<void(const Move&, const Chord&)>& emit) {
  const float radius_d = std::hypot(arc.center_x_d, arc.center_y_d);
  const Sweep sweep = sweep_of(arc);
  const float arc_d = radius_d * std::abs(sweep.angle);
  Move move{arc.to_d, arc.feed_v, arc.tag};
  if (!(arc_d > 0) || !std::isfinite(arc_d)) {
    emit(move, {});
    return;
  }
  const float count = chord_count(arc_d, sweep.least_chords);
  const auto limit = [](const PerAxis& values) { return static_cast<float>(std::min(values[0], values[1])); };
  const float accel_a = limit(limits.max_acceleration_mm_s2);
  const float speed_v = std::min(limit(limits.max_speed_mm_s), arc.feed_v);
  const float most_v2 = std::min(speed_v * speed_v, accel_a * radius_d);

  Chord chord;
  for (float i = 1; i < count; ++i) {
    const float done_r = i / count;
    const float angle = sweep.angle * done_r;
    const float c = std::cos(angle);
    const float s = std::sin(angle);
    move.target_d[0] = arc.from_d[0] + arc.center_x_d - arc.center_x_d * c + arc.center_y_d * s;
    move.target_d[1] = arc.from_d[1] + arc.center_y_d - arc.center_x_d * s - arc.center_y_d * c;
    for (std::size_t k = 2; k < move.target_d.size(); ++k) {
      move.target_d[k] = arc.from_d[k] + (arc.to_d[k] - arc.from_d[k]) * done_r;
    }
    chord.safe_exit_v2 = std::min(most_v2, 2 * accel_a * arc_d * (1 - done_r));
    emit(move, chord);
    chord.radius_d = radius_d;
  }
  move.target_d = arc.to_d;
  chord.safe_exit_v2 = 0;
  emit(move, chord);
}

}  // namespace voidpath::motion

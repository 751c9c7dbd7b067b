#include "engine/motion/junction.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace voidpath::motion {
namespace {

/// Below this the corner is a reversal, above its negative straight on. Single precision cannot tell more.
constexpr float kCosLimit = 0.999999F;
/// Lines shorter than this may be chords of an arc, where they meet at more than 135°.
constexpr float kChordMax_d = 1.0F;
constexpr float kCos135 = -0.7071067812F;
/// An axis speed change below this is rounding, not a jerk.
constexpr float kJunctionKeep_r = 0.99F;

/// The firmware's arc cosine for nearly straight corners: chords of the curve over intervals that halve
/// towards 1, raised so that the error is even on both sides (0.01 rad at most). JD_USE_LOOKUP_TABLE.
class ArcCosineTable {
 public:
  ArcCosineTable() {
    constexpr double kRaise = 1.00751495;
    for (std::size_t i = 0; i < kIntervals; ++i) {
      const bool last = i + 1 == kIntervals;
      const double x0 = 1 - std::ldexp(1.0, -static_cast<int>(i));
      const double x1 = last ? static_cast<double>(kCosLimit) : (1 + x0) / 2;
      const double y0 = std::acos(x0) * (i == 0 ? 1 : kRaise);
      const double y1 = std::acos(x1) * (last ? 1 : kRaise);
      slope_[i] = static_cast<float>((y0 - y1) / (x0 - x1));
      offset_[i] = static_cast<float>((y1 * x0 - y0 * x1) / (x0 - x1));
    }
  }
  /// For 0 ≤ x < 1.
  float operator()(float x) const {
    const auto scaled = static_cast<unsigned>((1 - x) * static_cast<float>(1U << (kIntervals - 1)));
    const auto width = static_cast<std::size_t>(std::bit_width(scaled));
    const std::size_t i = width >= kIntervals ? 0 : kIntervals - 1 - width;
    return x * slope_[i] + offset_[i];
  }

 private:
  static constexpr std::size_t kIntervals = 16;
  std::array<float, kIntervals> slope_{};
  std::array<float, kIntervals> offset_{};
};

/// The angle between two lines whose corner has cosine `c` below zero.
float chord_angle(float c) {
  static const ArcCosineTable table;
  return table(-c);
}

/// The change of one axis' speed across a corner: a difference when it goes on the same way, else the
/// larger of stopping and starting.
float axis_jump(float exit_v, float entry_v) {
  if (exit_v > entry_v) {
    return entry_v > 0 || exit_v < 0 ? exit_v - entry_v : std::max(exit_v, -entry_v);
  }
  return entry_v < 0 || exit_v > 0 ? entry_v - exit_v : std::max(-exit_v, entry_v);
}

}  // namespace

AxisFloats normalized(const AxisFloats& v) {
  float sum = 0;
  for (const float x : v) sum += x * x;
  if (sum <= 0) return v;
  const float scale = 1.0F / std::sqrt(sum);
  AxisFloats out;
  for (std::size_t i = 0; i < v.size(); ++i) out[i] = v[i] * scale;
  return out;
}

float limit_by_axis(float accel_a, const AxisFloats& unit, const AxisFloats& max_accel_a) {
  float limit = accel_a;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const float share = std::abs(unit[i]);
    if (share > 0 && limit * share > max_accel_a[i]) limit = max_accel_a[i] / share;
  }
  return limit;
}

float junction_deviation_v2(const AxisFloats& u, const AxisFloats& p, const DeviationParams& params) {
  float c = 0;
  for (std::size_t i = 0; i < u.size(); ++i) c -= p[i] * u[i];
  if (c > kCosLimit) return kMinPlannerV * kMinPlannerV;

  AxisFloats change;
  for (std::size_t i = 0; i < u.size(); ++i) change[i] = u[i] - p[i];
  const float accel_a = limit_by_axis(params.accel_a, normalized(change), params.max_accel_a);
  if (params.radius_d > 0) return accel_a * params.radius_d;

  c = std::max(c, -kCosLimit);
  const float s = std::sqrt(0.5F * (1.0F - c));
  const float v2 = accel_a * params.deviation_d * s / (1.0F - s);
  if (params.length_d < kChordMax_d && c < kCos135) {
    return std::min(v2, params.length_d * accel_a / chord_angle(c));
  }
  return v2;
}

float safe_speed(const AxisFloats& speed_v, float nominal_v, const AxisFloats& jerk_v) {
  float safe_v = nominal_v;
  bool limited = false;
  for (std::size_t i = 0; i < speed_v.size(); ++i) {
    const float jump = std::abs(speed_v[i]);
    if (jump <= jerk_v[i]) continue;
    if (!limited) {
      safe_v *= jerk_v[i] / jump;
      limited = true;
    } else if (const float most = nominal_v * jerk_v[i]; jump * safe_v > most) {
      safe_v = most / jump;
    }
  }
  return safe_v;
}

float jerk_junction_v(const AxisFloats& speed_v, float nominal_v, float safe_v, const JerkState& before,
                      const AxisFloats& jerk_v) {
  float junction_v = before.nominal_v;
  float smaller_r = 1;
  if (nominal_v < before.nominal_v) {
    junction_v = nominal_v;
    smaller_r = nominal_v / before.nominal_v;
  }
  float factor_r = 1;
  bool limited = false;
  for (std::size_t i = 0; i < speed_v.size(); ++i) {
    float exit_v = before.speed_v[i] * smaller_r;
    float entry_v = speed_v[i];
    if (limited) {
      exit_v *= factor_r;
      entry_v *= factor_r;
    }
    const float jump = axis_jump(exit_v, entry_v);
    if (jump > jerk_v[i]) {
      factor_r *= jerk_v[i] / jump;
      limited = true;
    }
  }
  if (limited) junction_v *= factor_r;
  const float threshold_v = junction_v * kJunctionKeep_r;
  // Stopping and starting within the jerk may be quicker than passing the corner.
  if (before.safe_v > threshold_v && safe_v > threshold_v) junction_v = safe_v;
  return junction_v;
}

}  // namespace voidpath::motion

#pragma once

#include "engine/motion/move.h"

/// How fast the head may pass from one straight line to the next.
/// u, p: unit vectors of this line and the one before it; c: cosine of the angle between -p and u, so that
/// straight on is -1 and a full reversal is +1.
namespace voidpath::motion {

/// Never slower than this at a corner. MINIMUM_PLANNER_SPEED.
inline constexpr float kMinPlannerV = 0.05F;

/// Scales the vector to length one; a null vector stays.
AxisFloats normalized(const AxisFloats& v);

/// The largest acceleration up to `accel_a` along `unit` that keeps each axis within its own limit.
float limit_by_axis(float accel_a, const AxisFloats& unit, const AxisFloats& max_accel_a);

struct DeviationParams {
  float accel_a = 0;  ///< of this line
  float length_d = 0;
  float deviation_d = 0;
  float radius_d = 0;  ///< of the arc this line is a chord of; 0: none
  AxisFloats max_accel_a{};
};
/// Junction deviation: v² = a·J·s/(1-s), s = sin(θ/2), a limited by axis along the change of direction.
/// Lines below 1 mm meeting at more than 135° also keep to v² = a·L/θ, the arc they seem to follow.
/// Planner::_populate_block, with JD_HANDLE_SMALL_SEGMENTS.
float junction_deviation_v2(const AxisFloats& u, const AxisFloats& p, const DeviationParams& params);

/// Corner state of the classic jerk rule: what the line before left behind.
struct JerkState {
  AxisFloats speed_v{};  ///< per axis, at its nominal speed
  float nominal_v = 0;
  float safe_v = 0;  ///< from which it may stop at once
};
/// The speed from which a line with axis speeds `speed_v` at `nominal_v` may start or end at rest.
float safe_speed(const AxisFloats& speed_v, float nominal_v, const AxisFloats& jerk_v);
/// Speed at the corner so that no axis jumps by more than its jerk; `safe_v` is this line's safe speed.
float jerk_junction_v(const AxisFloats& speed_v, float nominal_v, float safe_v, const JerkState& before,
                      const AxisFloats& jerk_v);

}  // namespace voidpath::motion

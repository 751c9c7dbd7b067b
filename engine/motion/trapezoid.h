#pragma once

#include "engine/motion/block.h"

#include <cstdint>

/// The speed profile of one block and the time it takes.
namespace voidpath::motion {

/// Profile in whole steps, as the stepper interrupt gets it.
struct StepProfile {
  std::uint32_t steps = 0;
  std::uint32_t accelerate_until = 0;
  std::uint32_t decelerate_after = 0;
  std::uint32_t initial_rate = 0;
  std::uint32_t nominal_rate = 0;
  std::uint32_t final_rate = 0;
  std::uint32_t accel_steps = 0;  ///< steps/s²
};

/// Planner::calculate_trapezoid_for_block: rates round up, never below 120 steps/s; acceleration steps
/// round up, deceleration steps down.
StepProfile step_profile(const Block& block, float entry_v, float exit_v);

/// Seconds the 2.0 line's stepper interrupt needs (Stepper::block_phase_isr). Interval 0 is 1/initial_rate;
/// the rate of interval n is initial + ⌊a·t⌋ while n ≤ accelerate_until (t from the block's start), the
/// nominal rate, and then (rate reached) - ⌊a·t⌋ while n > decelerate_after (t from the first such interval):
/// each step is timed by the speed at its beginning, so a deceleration has covered its steps too fast and
/// the block ends early. Constant time whatever the number of steps; see trapezoid.cpp.
double stepped_seconds(const StepProfile& profile);

/// The same, one step at a time. What stepped_seconds() abbreviates; for checking.
double stepped_seconds_by_loop(const StepProfile& profile);

/// Seconds of a continuous trapezoid: from entry_v up to nominal_v at accel_a, down to exit_v, over length_d.
/// Where the length does not allow the speed change, the exit speed gives way.
double ideal_seconds(double length_d, double entry_v, double nominal_v, double exit_v, double accel_a);

double block_seconds(const Block& block, float entry_v, float exit_v, Stepping stepping);

}  // namespace voidpath::motion

#pragma once

#include "engine/motion/junction.h"

/// Where the planner of MakerBot's and Sailfish firmware differs from Marlin's, from which it descends.
/// Source: Sailfish-MightyBoardFirmware, StepperAccelPlanner.cc ("yet another jerk"), StepperAccel.cc.
///
/// Reproduced: the corner rule; the acceleration, which an axis that cannot follow pulls down to its own
/// limit whatever its share of the move; every move of a step or more queued; the stepper starting at once.
/// Not reproduced: its fixed-point rounding, JKN advance's pressure relief, the slow-down of a nearly empty
/// queue.
namespace voidpath::motion::sailfish {

/// A move that meets an empty queue begins at this speed, and any may end at it. minimumPlannerSpeed, mm/s.
inline constexpr float kMinPlannerV = 2.0F;

/// Speed at which a move may be entered, so that no axis changes its speed by more than `jerk_v`. `before_v`
/// is what the last corner left behind; becomes what this one leaves: the axes' speeds at the corner, not
/// beyond it, so that a slow corner slows the next one too, as the firmware has it.
float junction_v(const AxisFloats& speed_v, float nominal_v, const AxisFloats& jerk_v, bool joins,
                 AxisFloats& before_v);

}  // namespace voidpath::motion::sailfish

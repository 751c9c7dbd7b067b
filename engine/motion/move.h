#pragma once

#include "engine/motion/limits.h"

#include <array>
#include <cstdint>

/// Suffixes of quantities in this room (everything else spells its unit out):
///   _d mm · _v mm/s · _v2 mm²/s² · _a mm/s² · _t s · _r ratio · _rate steps/s of the axis with most steps
/// Junction arithmetic stays in squared speeds. Frame: machine axes x, y, z and the filament e.
/// Planner arithmetic is single precision because the firmware's is: a rounding that falls the other way
/// changes a step count, and junction limits near 180° are differences of nearly equal numbers.
namespace voidpath::motion {

/// One value an axis, in the firmware's precision.
using AxisFloats = std::array<float, 4>;

inline constexpr int kAxes = 4;
inline constexpr int kE = 3;

/// A straight line to a position, as a G1 asks for it.
struct Move {
  AxisFloats target_d{};  ///< absolute, mm
  float feed_v = 0;       ///< mm/s, feed-rate override already applied
  std::uint64_t tag = 0;  ///< the caller's; comes back with the block
};

}  // namespace voidpath::motion

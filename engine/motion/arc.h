#pragma once

#include "engine/motion/planner.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

/// G2 and G3: the firmware cuts an arc into chords and plans those.
namespace voidpath::motion {

/// An arc in the xy plane; z and e change in proportion.
struct Arc {
  AxisFloats from_d{};
  AxisFloats to_d{};
  float center_x_d = 0;  ///< relative to from_d
  float center_y_d = 0;
  bool clockwise = false;
  int extra_turns = 0;  ///< P of G2 and G3: full turns before the arc itself
  float feed_v = 0;
  std::uint64_t tag = 0;
};

/// Centre (x, y), relative to `from_d`, of the arc with this radius between two points; a negative radius
/// goes the way that is longer than half a turn. Nothing where there is no such arc.
std::optional<std::pair<float, float>> arc_center(const AxisFloats& from_d, const AxisFloats& to_d,
                                                  float radius_d, bool clockwise);

/// Chords of at most 1 mm and at least 72 a turn (but none below 0.1 mm), in order. Marlin G2_G3.cpp,
/// plan_arc(), with MIN_ARC_SEGMENT_MM 0.1, MAX_ARC_SEGMENT_MM 1.0, MIN_CIRCLE_SEGMENTS 72.
void cut_arc(const Arc& arc, const MachineLimits& limits,
             const std::function<void(const Move&, const Chord&)>& emit);

}  // namespace voidpath::motion

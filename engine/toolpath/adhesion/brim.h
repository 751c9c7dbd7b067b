#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/walls/perimeters.h"

#include <vector>

namespace voidpath::toolpath {

/// A brim's lines. Both from outside inwards, so that the part is met last.
struct Brim {
  geom::Rings loops;     ///< closed
  geom::Polylines ears;  ///< each ear in one line, to and fro
};

/// Loops around `footprint` (part and supports on the plate) at the settings' gap: around it, in its holes,
/// or both. With ears: only near the sharp convex corners of `part`.
Brim make_brim(const geom::Regions& footprint, const geom::Regions& part, const SliceSettings& settings,
               const BeadSize& bead);

/// Corners of the outer contours whose inner angle, measured over some way to both sides, is at most this.
std::vector<geom::Point> sharp_corners(const geom::Regions& part, double max_angle_deg);

}  // namespace voidpath::toolpath

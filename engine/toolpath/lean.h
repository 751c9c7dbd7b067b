#pragma once

#include "engine/toolpath/settings.h"

/// What holds a line that lies beside what is below it. The slicer's own rules, so that overhangs, supports
/// and what is cut back for want of hold agree.
namespace voidpath::toolpath {

/// A line is carried by one below that it overlaps by so much of its width, whatever the angle.
inline constexpr double kCarriedShare = 0.25;
/// What is printed reaches this far over from a support beside it, mm: about what support keeps from the part.
inline constexpr double kBesideSupportMm = 0.5;

/// How far the part may lean out over the layer below without support, mm.
double lean_mm(const SliceSettings& settings, double height_mm);
/// How far support of a layer may lean out over support below it, mm: as the part, but it is never trusted to
/// hang over level.
double support_lean_mm(const SliceSettings& settings, double height_mm);

}  // namespace voidpath::toolpath

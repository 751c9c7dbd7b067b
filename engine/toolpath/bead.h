#pragma once

#include <algorithm>
#include <numbers>

namespace voidpath::toolpath {

/// What the round ends of a bead lack of a rectangle, as a share of its height.
inline constexpr double kRoundEnds = 1.0 - std::numbers::pi / 4.0;

/// Cross-section of a bead squeezed flat: a rectangle with half-round ends, mm². A bead narrower than it is
/// high counts as an ellipse.
inline double bead_area_mm2(double width_mm, double height_mm) {
  if (width_mm <= height_mm) return std::numbers::pi / 4.0 * width_mm * height_mm;
  return (width_mm - height_mm * kRoundEnds) * height_mm;
}

/// Distance of parallel beads that fill a layer without gaps: area divided by height.
inline double bead_spacing_mm(double width_mm, double height_mm) {
  return bead_area_mm2(width_mm, height_mm) / height_mm;
}

/// Width of the bead with this spacing; inverse of bead_spacing_mm.
inline double width_of_spacing_mm(double spacing_mm, double height_mm) {
  constexpr double kEllipse = std::numbers::pi / 4.0;
  return spacing_mm < kEllipse * height_mm ? spacing_mm / kEllipse : spacing_mm + height_mm * kRoundEnds;
}

/// A strand hanging in air is round.
inline double strand_area_mm2(double diameter_mm) {
  return std::numbers::pi / 4.0 * diameter_mm * diameter_mm;
}

}  // namespace voidpath::toolpath

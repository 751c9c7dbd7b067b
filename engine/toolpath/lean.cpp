#include "engine/toolpath/lean.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

/// Degrees from vertical. The part's limit is but what a tangent can be taken of.
constexpr double kMostLeanDeg = 89;
constexpr double kMostSupportLeanDeg = 60;

double leaning_mm(const SliceSettings& s, double height_mm, double most_deg) {
  const double angle = std::clamp(s.support_angle_deg, 0.0, most_deg) * std::numbers::pi / 180;
  return std::max(height_mm * std::tan(angle), kCarriedShare * s.line_width_mm);
}

}  // namespace

double lean_mm(const SliceSettings& settings, double height_mm) {
  return leaning_mm(settings, height_mm, kMostLeanDeg);
}

double support_lean_mm(const SliceSettings& settings, double height_mm) {
  return leaning_mm(settings, height_mm, kMostSupportLeanDeg);
}

}  // namespace voidpath::toolpath

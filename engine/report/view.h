#pragma once

#include "engine/geom/vec.h"
#include "engine/mesh/triangle_mesh.h"

#include <cmath>
#include <numbers>

namespace voidpath::report {

/// Parallel projection of a standing part, seen from the front, right and above. mm
///
/// right, up, away: where the picture's axes and the line of sight point in the part's space; orthonormal.
/// Away grows with the distance from the eye.
struct View {
  // 35° from the front, 24° above the plate: low enough to look under overhangs, high enough to see the
  // plate.
  static constexpr double kAround = 35.0 * std::numbers::pi / 180;
  static constexpr double kAbove = 24.0 * std::numbers::pi / 180;

  geom::Vec3 right{std::cos(kAround), std::sin(kAround), 0};
  geom::Vec3 away{-std::sin(kAround) * std::cos(kAbove), std::cos(kAround) * std::cos(kAbove),
                  -std::sin(kAbove)};
  geom::Vec3 up = right.cross(away);

  /// x: right, y: up, z: away.
  geom::Vec3 see(const geom::Vec3& p) const { return {right.dot(p), up.dot(p), away.dot(p)}; }
};

/// The plate under the part: its footprint and a margin. mm
struct Plate {
  double x0, y0, x1, y1;
  double grid;  ///< between lines
};
inline Plate plate_under(const mesh::Bounds& box) {
  const double size = std::max(box.size().x(), box.size().y());
  const double grid = size > 400 ? 100 : size > 150 ? 50 : size > 12 ? 10 : 1;
  const double margin = 0.06 * size + 0.3 * grid;
  return {box.min.x() - margin, box.min.y() - margin, box.max.x() + margin, box.max.y() + margin, grid};
}

}  // namespace voidpath::report

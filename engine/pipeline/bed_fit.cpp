#include "engine/pipeline/bed_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace voidpath::pipeline {

namespace {

using Point = Eigen::Vector2d;

/// Convex hull, counter-clockwise (Andrew's monotone chain, 1979).
std::vector<Point> hull_of_footprint(const mesh::TriangleMesh& mesh) {
  std::vector<Point> points;
  points.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) points.emplace_back(v.x(), v.y());
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Point> hull;
  const auto chain = [&](auto begin, auto end) {
    const std::size_t base = hull.size();
    for (auto it = begin; it != end; ++it) {
      while (hull.size() >= base + 2) {
        const Point a = hull[hull.size() - 1] - hull[hull.size() - 2];
        const Point b = *it - hull[hull.size() - 2];
        if (a.x() * b.y() - a.y() * b.x() > 0) break;
        hull.pop_back();
      }
      hull.push_back(*it);
    }
    if (!hull.empty()) hull.pop_back();
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  if (hull.empty() && !points.empty()) hull.push_back(points.front());
  return hull;
}

bool fits(const std::vector<Point>& hull, double angle, double x_mm, double y_mm) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  Point lo = Point::Constant(1e300);
  Point hi = -lo;
  for (const Point& p : hull) {
    const Point q(c * p.x() - s * p.y(), s * p.x() + c * p.y());
    lo = lo.cwiseMin(q);
    hi = hi.cwiseMax(q);
  }
  // A part exactly as large as the bed fits, whatever rounding did to its corners.
  constexpr double kRounding_mm = 1e-6;
  return hi.x() - lo.x() <= x_mm + kRounding_mm && hi.y() - lo.y() <= y_mm + kRounding_mm;
}

}  // namespace

std::optional<double> bed_turn(const mesh::TriangleMesh& mesh, const std::array<double, 2>& bed_mm,
                               double margin_mm) {
  const double x = bed_mm[0] - 2 * margin_mm;
  const double y = bed_mm[1] - 2 * margin_mm;
  const auto hull = hull_of_footprint(mesh);
  constexpr double kQuarter = std::numbers::pi / 2;
  if (fits(hull, 0, x, y)) return 0;
  if (fits(hull, kQuarter, x, y)) return kQuarter;
  for (int degree = 1; degree < 180; ++degree)
    if (const double angle = degree * std::numbers::pi / 180; fits(hull, angle, x, y)) return angle;
  return std::nullopt;
}

mesh::TriangleMesh turned_about_z(const mesh::TriangleMesh& mesh, double angle) {
  mesh::TriangleMesh out = mesh;
  if (angle != 0)
    out = mesh::rotated(mesh, geom::Quaternion(Eigen::AngleAxisd(angle, geom::Vec3::UnitZ())));
  const mesh::Bounds b = mesh::bounds(out);
  const geom::Vec3 shift(-0.5 * (b.min.x() + b.max.x()), -0.5 * (b.min.y() + b.max.y()), 0);
  for (auto& v : out.vertices) v += shift;
  return out;
}

}  // namespace voidpath::pipeline

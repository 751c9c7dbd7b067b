#include "engine/orient/directions.h"

#include "engine/orient/convex_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace voidpath::orient {

namespace {

using Corner = std::array<Vec3, 3>;

/// The 20 faces of the icosahedron on the cyclic permutations of (0, ±1, ±φ): all triples of vertices that
/// are pairwise one edge (2) apart.
std::vector<Corner> icosahedron() {
  std::vector<Vec3> v;
  for (int axis = 0; axis < 3; ++axis)
    for (const double one : {-1.0, 1.0})
      for (const double phi : {-std::numbers::phi, std::numbers::phi}) {
        Vec3 p = Vec3::Zero();
        p[(axis + 1) % 3] = one;
        p[(axis + 2) % 3] = phi;
        v.push_back(p);
      }
  auto joined = [&](std::size_t a, std::size_t b) { return std::abs((v[a] - v[b]).norm() - 2.0) < 1e-9; };
  std::vector<Corner> faces;
  for (std::size_t a = 0; a < v.size(); ++a)
    for (std::size_t b = a + 1; b < v.size(); ++b)
      for (std::size_t c = b + 1; c < v.size(); ++c)
        if (joined(a, b) && joined(b, c) && joined(a, c))
          faces.push_back({v[a].normalized(), v[b].normalized(), v[c].normalized()});
  return faces;
}

}  // namespace

bool is_canonical(const Vec3& d) {
  if (d.z() != 0) return d.z() > 0;
  if (d.y() != 0) return d.y() > 0;
  return d.x() > 0;
}

std::vector<Vec3> icosphere_directions(int subdivisions) {
  // The set is symmetric about the origin: half the faces are split, and each direction brings its negative.
  std::vector<Corner> faces;
  for (const Corner& f : icosahedron())
    if (is_canonical(f[0] + f[1] + f[2])) faces.push_back(f);
  for (int n = 0; n < subdivisions; ++n) {
    std::vector<Corner> finer;
    finer.reserve(faces.size() * 4);
    for (const auto& [a, b, c] : faces) {
      const Vec3 ab = (a + b).normalized();
      const Vec3 bc = (b + c).normalized();
      const Vec3 ca = (c + a).normalized();
      finer.push_back({a, ab, ca});
      finer.push_back({b, bc, ab});
      finer.push_back({c, ca, bc});
      finer.push_back({ab, bc, ca});
    }
    faces = std::move(finer);
  }
  std::vector<Vec3> out;
  out.reserve(faces.size() * 2);
  for (const auto& [a, b, c] : faces) {
    const Vec3 d = (a + b + c).normalized();
    out.push_back(d);
    out.push_back(-d);
  }
  return out;
}

std::vector<Vec3> axis_directions() {
  return {Vec3::UnitX(), -Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitY(), Vec3::UnitZ(), -Vec3::UnitZ()};
}

std::vector<RestingFace> resting_faces(const std::vector<Vec3>& points, std::size_t limit) {
  struct Facet {
    Vec3 area_vector;
    double area;
  };
  std::vector<Facet> facets;
  for (const auto& f : convex_hull(points)) {
    const Vec3 n = 0.5 * (points[f[1]] - points[f[0]]).cross(points[f[2]] - points[f[0]]);
    if (n.norm() > 0) facets.push_back({n, n.norm()});
  }
  std::stable_sort(facets.begin(), facets.end(),
                   [](const Facet& a, const Facet& b) { return a.area > b.area; });

  // Greedy: the largest facet not yet taken starts a face and gathers those that look the same way. A hull is
  // convex, so looking the same way means lying in the same plane.
  std::vector<RestingFace> faces;
  std::vector<Vec3> sums;
  const double same = std::cos(kCoplanarAngle);
  for (const Facet& f : facets) {
    const Vec3 n = f.area_vector / f.area;
    const auto known = std::find_if(faces.begin(), faces.end(),
                                    [&](const RestingFace& r) { return -r.direction.dot(n) >= same; });
    if (known != faces.end()) {
      sums[static_cast<std::size_t>(known - faces.begin())] += f.area_vector;
    } else if (faces.size() < 4 * limit) {
      faces.push_back({-n, 0});
      sums.push_back(f.area_vector);
    }
  }
  for (std::size_t i = 0; i < faces.size(); ++i) {
    faces[i].area_mm2 = sums[i].norm();
    faces[i].direction = -sums[i].normalized();
  }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const RestingFace& a, const RestingFace& b) { return a.area_mm2 > b.area_mm2; });
  if (faces.size() > limit) faces.resize(limit);
  return faces;
}

Angles angles_of(const Vec3& direction) {
  // Rz(z) turns d within the xy-plane until its x is 0, then Rx(x) turns (0, y', z') to +y.
  const Vec3 d = direction.normalized();
  Angles out;
  const double flat = std::hypot(d.x(), d.y());
  double y = 0;
  // On the z axis any z angle does; 0 is the plain one.
  if (flat > 0) {
    // z = atan2(dx, dy) gives y' = +flat; folded into [-π/2, π/2], y' takes the sign of dy.
    out.z = d.y() >= 0 ? std::atan2(d.x(), d.y()) : std::atan2(-d.x(), -d.y());
    y = d.y() >= 0 ? flat : -flat;
  }
  out.x = std::atan2(-d.z(), y);
  if (out.x < 0) out.x += 2 * std::numbers::pi;
  if (out.x >= 2 * std::numbers::pi) out.x = 0;
  return out;
}

}  // namespace voidpath::orient

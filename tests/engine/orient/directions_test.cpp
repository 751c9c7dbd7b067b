#include "engine/orient/directions.h"

#include "engine/orient/convex_hull.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <tuple>

#include <catch2/catch.hpp>

namespace voidpath::test {

using geom::Vec3;

namespace {

auto key(const Vec3& v) { return std::tuple(v.x(), v.y(), v.z()); }

/// Every point below every facet, and as many facets as Euler's formula wants.
void check_hull(const std::vector<Vec3>& points, const std::vector<mesh::Triangle>& hull) {
  std::set<std::uint32_t> used;
  double worst = 0;
  for (const auto& t : hull) {
    const Vec3 n = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).normalized();
    for (const Vec3& p : points) worst = std::max(worst, n.dot(p - points[t[0]]));
    used.insert(t.begin(), t.end());
  }
  CHECK(worst < 1e-4);  // a millionth of their size
  CHECK(hull.size() == 2 * used.size() - 4);
}

}  // namespace

TEST_CASE("an icosphere of three subdivisions and the axes make 1286 directions") {
  const auto sphere = orient::icosphere_directions(3);
  const auto axes = orient::axis_directions();
  CHECK(sphere.size() == 1280);
  CHECK(axes.size() == 6);
  CHECK(orient::icosphere_directions(0).size() == 20);
  std::set<std::tuple<double, double, double>> all;
  for (const auto& list : {sphere, axes})
    for (const Vec3& d : list) {
      CHECK(d.norm() == Approx(1).epsilon(1e-14));
      all.insert(key(d));
    }
  CHECK(all.size() == 1286);
  for (const Vec3& d : sphere) REQUIRE(all.count(key(-d)) == 1);
}

TEST_CASE("no point of the sphere is far from a sampled direction") {
  const auto sphere = orient::icosphere_directions(3);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = Vec3(normal(random), normal(random), normal(random)).normalized();
    double nearest = -1;
    for (const Vec3& d : sphere) nearest = std::max(nearest, d.dot(p));
    // 1280 triangles of 4π / 1280: their corners lie some 5° from their middles.
    REQUIRE(std::acos(nearest) < 6.5 * std::numbers::pi / 180);
  }
}

TEST_CASE("the angles turn a direction to +y") {
  auto directions = orient::icosphere_directions(2);
  for (const Vec3& d : orient::axis_directions()) directions.push_back(d);
  directions.push_back(Vec3(1e-17, -1, 0));
  for (const Vec3& d : directions) {
    const orient::Angles a = orient::angles_of(d);
    const Vec3 turned = (Eigen::AngleAxisd(a.x, Vec3::UnitX()) * Eigen::AngleAxisd(a.z, Vec3::UnitZ())) * d;
    CHECK((turned - Vec3::UnitY()).norm() < 1e-12);
    CHECK(a.x >= 0);
    CHECK(a.x < 2 * std::numbers::pi);
    CHECK(std::abs(a.z) <= std::numbers::pi / 2);
  }
}

TEST_CASE("hulls of random clouds, grids and spheres hold every point") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> u(-50, 50);
  for (int round = 0; round < 20; ++round) {
    std::vector<Vec3> cloud;
    for (int i = 0; i < 200; ++i) cloud.emplace_back(u(random), u(random), u(random));
    check_hull(cloud, orient::convex_hull(cloud));
  }
  const auto ball = sphere(10, 20, 30).vertices;
  check_hull(ball, orient::convex_hull(ball));
  CHECK(orient::convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {2, 3, 0}}).empty());
}

TEST_CASE("a tetrahedron rests on four faces, a turned box on six") {
  const std::vector<Vec3> corners{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}, {0, 0, 10}};
  const auto four = orient::resting_faces(corners);
  REQUIRE(four.size() == 4);
  CHECK(four[0].area_mm2 == Approx(100 * std::sqrt(3) / 2));
  CHECK((four[0].direction + Vec3(1, 1, 1).normalized()).norm() < 1e-12);

  const geom::Quaternion q = geom::Quaternion(0.3, 0.8, -0.2, 0.5).normalized();
  const auto six = orient::resting_faces(mesh::rotated(box(30, 20, 10), q).vertices);
  REQUIRE(six.size() == 6);
  CHECK(six[0].area_mm2 == Approx(600));
  CHECK(six[5].area_mm2 == Approx(200));
  CHECK(std::abs((q * Vec3::UnitZ()).dot(six[0].direction)) == Approx(1).epsilon(1e-12));
}

TEST_CASE("coplanar hull points, exact or off by noise, make one face") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-2e-6, 2e-6);
  for (const bool noisy : {false, true}) {
    std::vector<Vec3> points;
    for (int i = 0; i <= 12; ++i)
      for (int j = 0; j <= 12; ++j)
        for (int k = 0; k <= 12; k += 12) {
          points.emplace_back(i, j, k);
          points.emplace_back(k, i, j);
          points.emplace_back(j, k, i);
        }
    if (noisy)
      for (Vec3& p : points) p += Vec3(noise(random), noise(random), noise(random));
    check_hull(points, orient::convex_hull(points));
    const auto faces = orient::resting_faces(points);
    REQUIRE(faces.size() >= 6);
    for (std::size_t i = 0; i < 6; ++i) {
      CHECK(faces[i].area_mm2 == Approx(144).epsilon(1e-3));
      CHECK(faces[i].direction.cwiseAbs().maxCoeff() > 1 - 1e-6);
    }
    for (std::size_t i = 6; i < faces.size(); ++i) CHECK(faces[i].area_mm2 < 0.1);
  }
}

}  // namespace voidpath::test

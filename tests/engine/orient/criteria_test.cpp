#include "engine/orient/search.h"
#include "tests/engine/orient/reference.h"
#include "tests/support/meshes.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

namespace voidpath::test {

namespace {

using geom::Vec3;
using mesh::TriangleMesh;
using orient::Criteria;

constexpr double kExact = 1e-9;  ///< rounding of doubles, relative

Criteria of(const TriangleMesh& m, const Vec3& d, orient::CriticalRule rule = orient::CriticalRule::normals) {
  orient::SearchOptions options;
  options.critical = rule;
  return orient::evaluate(m, {d.normalized()}, options).at(0);
}

/// What a V may be off by: 1 % of it or 0.5 % of the bounding volume.
double v_tolerance(const TriangleMesh& m, const Vec3& d, double v) {
  return std::max(0.01 * v, 0.005 * bounding_volume(m, d));
}

void check(const Criteria& c, double h, double v, double contours, double distance, double tolerance_v) {
  CHECK(c.height_mm == Approx(h).epsilon(kExact));
  CHECK(c.contours == Approx(contours).epsilon(kExact));
  CHECK(c.void_mm == Approx(distance).epsilon(kExact).margin(1e-9));
  CHECK(std::abs(c.trapped_mm3 - v) <= tolerance_v);
}

const Vec3 kOdd[] = {Vec3(0.3, 0.5, 0.81).normalized(), Vec3(-0.62, 0.11, 0.4).normalized(),
                     Vec3(0.05, -0.9, -0.33).normalized(), Vec3(-0.7, -0.69, 0.02).normalized()};

}  // namespace

TEST_CASE("a cube on a face, an edge and a corner") {
  const double a = 20;
  const TriangleMesh m = cube(a);
  for (const Vec3& d : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)})
    check(of(m, d), a, 0, 1, 0, 1e-6);
  // On an edge: half the square prism around it is empty, half of that below. On a corner: of the hexagonal
  // prism of 3 a³ around it a³ is full, and half of the rest is below.
  check(of(m, Vec3(1, 1, 0)), a * std::sqrt(2), a * a * a / 2, 1, 0, 1e-6);
  check(of(m, Vec3(1, -1, 1)), a * std::sqrt(3), a * a * a, 1, 0, 1e-6);
}

TEST_CASE("a box turned about an edge traps two triangles' worth") {
  const double w = 30;
  const double h = 12;
  const double depth = 25;
  const TriangleMesh m = box(w, depth, h);
  for (const double degrees : {1.0, 7.0, 30.0, 45.0, 61.3, 89.0}) {
    const double s = std::sin(degrees * std::numbers::pi / 180);
    const double c = std::cos(degrees * std::numbers::pi / 180);
    // Below the turned rectangle lie triangles of legs (w c, w s) and (h s, h c).
    const Criteria up = of(m, Vec3(s, 0, c));
    CHECK(up.height_mm == Approx(w * s + h * c).epsilon(kExact));
    CHECK(up.trapped_mm3 == Approx(depth * (w * w + h * h) * s * c / 2).epsilon(1e-6));
    CHECK(up.contours == Approx(1).epsilon(kExact));
    CHECK(up.void_mm == 0);
  }
}

TEST_CASE("a cylinder standing and lying") {
  const double r = 10;
  const double l = 30;
  const TriangleMesh m = cylinder(r, l, 64);
  check(of(m, Vec3::UnitZ()), l, 0, 1, 0, 1e-6);
  const double area = 32 * r * r * std::sin(2 * std::numbers::pi / 64);
  check(of(m, Vec3::UnitX()), 2 * r, (4 * r * r - area) / 2 * l, 1, 0, 1e-3);
}

TEST_CASE("a cup traps its inside unless it is upright") {
  const TriangleMesh m = cup(30, 24, 20, 2, 3);
  const double inside = 26 * 20 * 17.0;
  check(of(m, Vec3::UnitZ()), 20, 0, 1, 0, 1e-6);
  check(of(m, -Vec3::UnitZ()), 20, inside, 1, 0, v_tolerance(m, Vec3::UnitZ(), inside));
  check(of(m, Vec3::UnitX()), 30, inside, 1, 0, v_tolerance(m, Vec3::UnitX(), inside));
  check(of(m, -Vec3::UnitY()), 24, inside, 1, 0, v_tolerance(m, Vec3::UnitY(), inside));
}

TEST_CASE("a comb has as many regions as posts") {
  const int n = GENERATE(2, 5, 13);
  const double post = 3;
  const double gap = 2.5;
  const TriangleMesh m = comb(n, post, gap, 15, 5);
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) sum += (j - i) * (post + gap) - post;
  const double mean = sum / (n * (n - 1) / 2.0);
  const double between = (n - 1) * gap * post * 15;
  check(of(m, Vec3::UnitZ()), 20, 0, (5 + 15.0 * n) / 20, 0.75 * mean, 1e-6);
  check(of(m, -Vec3::UnitZ()), 20, between, (5 + 15.0 * n) / 20, 0.75 * mean,
        v_tolerance(m, Vec3::UnitZ(), between));
  check(of(m, Vec3::UnitX()), n * post + (n - 1) * gap, between, 1, 0,
        v_tolerance(m, Vec3::UnitX(), between));
  check(of(m, Vec3::UnitY()), post, 0, 1, 0, 1e-6);
}

TEST_CASE("a table stands on four regions") {
  const TriangleMesh m = table(40, 30, 20, 4, 5);
  const double under = (40 * 30 - 4 * 25) * 16.0;
  const double distance = 0.8 * (2 * 30 + 2 * 20 + 2 * std::hypot(30, 20)) / 6;
  check(of(m, Vec3::UnitZ()), 20, under, 3.4, distance, v_tolerance(m, Vec3::UnitZ(), under));
  check(of(m, -Vec3::UnitZ()), 20, 0, 3.4, distance, 1e-6);
}

TEST_CASE("an island in a hole is as far as the hole's wall") {
  // A post of 4 mm standing in the middle of a tube of 20 × 20 mm with walls of 2 mm, on nothing in common.
  const TriangleMesh tube = joined(cup(20, 20, 12, 2, 2), moved(box(4, 4, 8), 8, 8, 3));
  const Criteria c = of(tube, Vec3::UnitZ());
  // Cup from 0 to 12, floor to 2; the post from 3 to 11: two regions, 6 mm apart, over 8 of 12 mm.
  CHECK(c.contours == Approx((4 + 2 * 8) / 12.0).epsilon(kExact));
  CHECK(c.void_mm == Approx(6 * 8 / 12.0).epsilon(kExact));
  CHECK(c.trapped_mm3 == Approx(4 * 4 * 1.0).margin(v_tolerance(tube, Vec3::UnitZ(), 0)));
}

TEST_CASE("turning the part with the direction changes no criterion") {
  const TriangleMesh shapes[] = {table(40, 30, 20, 4, 5), comb(4, 3, 2.5, 15, 5), cup(30, 24, 20, 2, 3),
                                 cylinder(10, 30, 24)};
  const geom::Quaternion turns[] = {geom::Quaternion(0.9, 0.1, -0.4, 0.2).normalized(),
                                    geom::Quaternion(-0.2, 0.7, 0.3, 0.61).normalized()};
  for (const TriangleMesh& m : shapes)
    for (const geom::Quaternion& q : turns)
      for (const Vec3& d : {Vec3(0, 0, 1), Vec3(1, 0, 0), kOdd[0], kOdd[1]}) {
        const Criteria a = of(m, d);
        const TriangleMesh turned = mesh::rotated(m, q);
        const Criteria b = of(turned, q * d);
        CHECK(b.height_mm == Approx(a.height_mm).epsilon(kExact));
        CHECK(b.contours == Approx(a.contours).epsilon(1e-6));
        CHECK(b.void_mm == Approx(a.void_mm).epsilon(1e-6).margin(1e-9));
        CHECK(std::abs(b.trapped_mm3 - a.trapped_mm3) <= v_tolerance(m, d, a.trapped_mm3));
      }
}

TEST_CASE("a mirrored part has the criteria of the mirrored direction") {
  const TriangleMesh m = joined(table(40, 30, 20, 4, 5), moved(comb(3, 4, 2, 9, 3), 60, 7, 0));
  TriangleMesh mirrored = m;
  for (Vec3& v : mirrored.vertices) v.x() = -v.x();
  for (auto& t : mirrored.triangles) std::swap(t[1], t[2]);
  for (const Vec3& d : kOdd) {
    const Criteria a = of(m, d);
    const Criteria b = of(mirrored, Vec3(-d.x(), d.y(), d.z()));
    CHECK(b.height_mm == Approx(a.height_mm).epsilon(kExact));
    CHECK(b.contours == Approx(a.contours).epsilon(1e-6));
    CHECK(b.void_mm == Approx(a.void_mm).epsilon(1e-6));
    CHECK(std::abs(b.trapped_mm3 - a.trapped_mm3) <= v_tolerance(m, d, a.trapped_mm3));
  }
}

TEST_CASE("generated parts agree with the reference") {
  TriangleMesh bumpy = sphere(15, 24, 40);
  for (Vec3& v : bumpy.vertices) {
    const Vec3 r = v - Vec3(0, 0, 15);
    v += r.normalized() * 3 * std::sin(0.7 * r.x()) * std::cos(0.9 * r.y() + r.z());
  }
  const TriangleMesh shapes[] = {bumpy, table(40, 30, 20, 4, 5), comb(6, 3, 2.5, 15, 5),
                                 joined(cup(30, 24, 20, 2, 3), moved(sphere(5, 12, 18), 15, 12, 5)),
                                 joined(cylinder(10, 30, 24), moved(cylinder(4, 22, 17), 20, 3, 2))};
  for (const TriangleMesh& m : shapes)
    for (const Vec3& d : kOdd)
      for (const bool morse : {false, true}) {
        const Criteria c = of(m, d, morse ? orient::CriticalRule::morse : orient::CriticalRule::normals);
        ReferenceOptions options;
        options.morse = morse;
        const Criteria r = reference_criteria(m, d, options);
        CHECK(c.height_mm == Approx(r.height_mm).epsilon(kExact));
        CHECK(c.contours == Approx(r.contours).epsilon(1e-6));
        CHECK(c.void_mm == Approx(r.void_mm).epsilon(1e-6).margin(1e-9));
        CHECK(std::abs(c.trapped_mm3 - r.trapped_mm3) <= v_tolerance(m, d, r.trapped_mm3));
      }
}

}  // namespace voidpath::test

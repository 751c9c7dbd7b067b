#include "engine/orient/search.h"
#include "tests/engine/orient/reference.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <catch2/catch.hpp>

namespace voidpath::test {

using geom::Vec3;
using mesh::TriangleMesh;
using orient::Criteria;

namespace {

Criteria of(const TriangleMesh& m, const Vec3& d) { return orient::evaluate(m, {d.normalized()}, {}).at(0); }

TriangleMesh inside_out(TriangleMesh m) {
  for (auto& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

}  // namespace

TEST_CASE("a slice through vertices and along faces closes") {
  // Steps of 0.4 mm are dropped from the critical heights, so that slices fall on flat faces and their
  // corners.
  TriangleMesh stairs = box(40, 10, 2);
  for (int i = 1; i < 12; ++i)
    stairs = joined(stairs, moved(box(40 - 3.0 * i, 10, 0.4), 0, 0, 1.6 + 0.4 * i));
  const Criteria c = of(stairs, Vec3::UnitZ());
  CHECK(c.height_mm == Approx(6.4));
  CHECK(c.contours == Approx(1).epsilon(1e-9));
  CHECK(c.void_mm == 0);
  // Two posts of equal height beside one of half that: the middle of the tall slab meets its top exactly.
  TriangleMesh posts = joined(box(30, 10, 2), moved(box(4, 4, 10), 0, 0, 2));
  posts = joined(posts, moved(box(4, 4, 10), 20, 0, 2));
  const Criteria p = of(posts, Vec3::UnitZ());
  CHECK(p.contours == Approx((2 + 2 * 10) / 12.0));
  CHECK(p.void_mm == Approx(16 * 10 / 12.0));
}

TEST_CASE("bodies that overlap are one") {
  // Two cubes of 10, overlapping by 4 × 10 × 10.
  const TriangleMesh two = joined(cube(10), moved(cube(10), 6, 0, 0));
  const Criteria one = of(box(16, 10, 10), Vec3(0.2, 0.3, 0.9));
  const Criteria c = of(two, Vec3(0.2, 0.3, 0.9));
  CHECK(c.height_mm == Approx(one.height_mm));
  CHECK(c.contours == Approx(1));
  CHECK(c.void_mm == 0);
  CHECK(std::abs(c.trapped_mm3 - one.trapped_mm3) <= 0.005 * bounding_volume(two, Vec3(0.2, 0.3, 0.9)));
  CHECK(of(two, Vec3::UnitZ()).trapped_mm3 == Approx(0).margin(0.005 * 1600));
}

TEST_CASE("bodies that lie on one another are one, with the same corners or not") {
  for (const double shift : {0.0, 2.5}) {
    // A file of single precision may leave a crack.
    for (const double crack : {0.0, 1e-6}) {
      const TriangleMesh two = joined(cube(10), moved(cube(10), 10 + crack, shift, 0));
      for (const Vec3& d : {Vec3(0, 0, 1), Vec3(0.3, 0.2, 0.8), Vec3(-0.5, 0.1, 0.4)}) {
        const Criteria c = of(two, d);
        CHECK(c.contours == Approx(1).epsilon(1e-9));
        CHECK(c.void_mm == Approx(0).margin(1e-9));
      }
    }
  }
}

TEST_CASE("bodies that lie on one another are one also where they share vertices, as a file's do") {
  TriangleMesh two = joined(cube(10), moved(cube(10), 10, 0, 0));
  std::vector<std::uint32_t> first(two.vertices.size());
  for (std::uint32_t v = 0; v < first.size(); ++v)
    first[v] = static_cast<std::uint32_t>(
        std::find(two.vertices.begin(), two.vertices.end(), two.vertices[v]) - two.vertices.begin());
  for (auto& t : two.triangles)
    for (auto& v : t) v = first[v];
  for (const Vec3& d : {Vec3(0, 0, 1), Vec3(0.3, 0.2, 0.8), Vec3(-0.5, 0.1, 0.4)}) {
    const Criteria c = of(two, d);
    CHECK(c.contours == Approx(1).epsilon(1e-9));
    CHECK(c.void_mm == Approx(0).margin(1e-9));
  }
}

TEST_CASE("a body across a hole, and one in the hole, and a body that fills a cavity") {
  // A square tube with a bar through both its walls; beside the bar a post in the open, inside.
  TriangleMesh tube = cup(20, 20, 12, 2, 2);
  const TriangleMesh crossed = joined(tube, moved(box(30, 4, 4), -5, 8, 5));
  const TriangleMesh post = joined(crossed, moved(box(2, 2, 8), 9, 3, 3));
  const Criteria c = of(post, Vec3::UnitZ());
  // Floor to 2; post from 3 to 11; bar from 5 to 9. The slice of each slab of the normals' rule is exact
  // here. The post is 1 mm from the wall (y 2) and 3 from the bar.
  CHECK(c.contours == Approx((3 + 8 * 2 + 1) / 12.0).epsilon(1e-9));
  CHECK(c.void_mm == Approx(8 * 1 / 12.0).epsilon(1e-9));
  // A cavity filled by a body that overlaps its walls is no cavity and no region of its own.
  const TriangleMesh hollow = joined(cube(20), inside_out(moved(cube(8), 6, 6, 6)));
  const Criteria plug = of(joined(hollow, moved(cube(10), 5, 5, 5)), Vec3::UnitZ());
  CHECK(plug.contours == Approx(1));
  CHECK(plug.void_mm == 0);
  // Two posts joined by a bar are one region where the bar is, else two.
  TriangleMesh gate = joined(moved(cube(10), 0, 0, 0), moved(cube(10), 30, 0, 0));
  gate = joined(gate, moved(box(30, 4, 4), 5, 3, 3));
  const Criteria g = of(gate, Vec3::UnitZ());
  CHECK(g.contours == Approx((2 * 6 + 4) / 10.0));
  CHECK(g.void_mm == Approx(20 * 6 / 10.0));
}

TEST_CASE("bodies that touch along an edge stay two regions without a gap") {
  const TriangleMesh two = joined(cube(10), moved(cube(10), 10, 10, 0));
  const Criteria c = of(two, Vec3::UnitZ());
  CHECK(c.contours == Approx(2));
  CHECK(c.void_mm == Approx(0).margin(1e-6));
}

TEST_CASE("a body inside material adds nothing; a cavity is trapped") {
  const Vec3 d(0.1, -0.4, 0.7);
  const TriangleMesh solid = cube(20);
  const Criteria plain = of(solid, d);
  const Criteria swallowed = of(joined(solid, moved(cube(8), 6, 6, 6)), d);
  CHECK(swallowed.contours == Approx(plain.contours));
  CHECK(swallowed.void_mm == 0);
  const double box = bounding_volume(solid, d);
  CHECK(std::abs(swallowed.trapped_mm3 - plain.trapped_mm3) <= 0.005 * box);

  const TriangleMesh hollow = joined(solid, inside_out(moved(cube(8), 6, 6, 6)));
  const Criteria cavity = of(hollow, d);
  CHECK(cavity.contours == Approx(1));
  CHECK(std::abs(cavity.trapped_mm3 - plain.trapped_mm3 - 512) <= 0.005 * box);
  // A body in the cavity is a region of its own.
  const Criteria rattle = of(joined(hollow, moved(cube(2), 9, 9, 9)), Vec3::UnitZ());
  CHECK(rattle.contours == Approx((20 + 2) / 20.0));
  CHECK(rattle.void_mm == Approx(3 * 2 / 20.0));
}

TEST_CASE("a body inside out counts as it should have been") {
  const Vec3 d(0.3, 0.5, 0.81);
  const TriangleMesh m = table(40, 30, 20, 4, 5);
  const Criteria a = of(m, d);
  const Criteria b = of(inside_out(m), d);
  CHECK(b.contours == Approx(a.contours));
  CHECK(b.void_mm == Approx(a.void_mm));
  CHECK(b.trapped_mm3 == Approx(a.trapped_mm3).epsilon(1e-6));
}

TEST_CASE("slivers, a flat sheet and nothing at all do no harm") {
  TriangleMesh m = cube(10);
  // A facet split by a point a hair from its edge, and one without area.
  const auto t = m.triangles[0];
  const auto v = static_cast<std::uint32_t>(m.vertices.size());
  m.vertices.push_back(0.5 * (m.vertices[t[0]] + m.vertices[t[1]]));
  m.triangles[0] = {t[0], v, t[2]};
  m.triangles.push_back({v, t[1], t[2]});
  m.triangles.push_back({t[0], t[1], v});
  const Criteria c = of(m, Vec3(0.2, 0.3, 0.9));
  CHECK(c.contours == Approx(1));
  const TriangleMesh sheet{{{0, 0, 0}, {10, 0, 0}, {0, 10, 0}}, {{0, 1, 2}}};
  CHECK(of(sheet, Vec3::UnitZ()).height_mm == 0);
  CHECK(of(sheet, Vec3(0, 1, 1)).height_mm > 0);
  CHECK(of(TriangleMesh{}, Vec3::UnitZ()).height_mm == 0);
}

TEST_CASE("thousands of regions in a slice take no time to speak of") {
  // 45 × 45 posts on a plate.
  TriangleMesh m = box(90, 90, 2);
  double sum = 0;
  const int n = 45;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) m = joined(m, moved(box(1, 1, 5), 2.0 * i, 2.0 * j, 2));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n * n; ++k) {
        const double dx = std::max(0.0, 2.0 * std::abs(i - k / n) - 1);
        const double dy = std::max(0.0, 2.0 * std::abs(j - k % n) - 1);
        sum += std::hypot(dx, dy) / 2;
      }
  const Criteria c = of(m, Vec3::UnitZ());
  const double pairs = n * n * (n * n - 1) / 2.0;
  CHECK(c.contours == Approx((2 + 5.0 * n * n) / 7));
  CHECK(c.void_mm == Approx(sum / pairs * 5 / 7).epsilon(1e-9));
}

}  // namespace voidpath::test

#include "engine/mesh/repair.h"

#include "engine/mesh/inspect.h"
#include "engine/mesh/weld.h"
#include "tests/support/meshes.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace voidpath;
using mesh::TriangleMesh;

namespace {

TriangleMesh inside_out(TriangleMesh m) {
  for (mesh::Triangle& t : m.triangles) std::swap(t[1], t[2]);
  return m;
}

/// Every facet with corners of its own.
TriangleMesh exploded(const TriangleMesh& m) {
  TriangleMesh out;
  for (const mesh::Triangle& t : m.triangles) {
    const auto n = static_cast<std::uint32_t>(out.vertices.size());
    for (const std::uint32_t v : t) out.vertices.push_back(m.vertices[v]);
    out.triangles.push_back({n, n + 1, n + 2});
  }
  return out;
}

TriangleMesh block_with_cavity() {
  return test::joined(test::box(30, 30, 30), inside_out(test::moved(test::sphere(5), 15, 15, 10)));
}

std::vector<TriangleMesh> sound_meshes() {
  return {test::cube(10),
          test::cylinder(5, 20),
          test::cup(30, 30, 20, 2, 2),
          test::comb(5, 4, 3, 10, 2),
          test::sphere(8),
          block_with_cavity(),
          test::joined(test::cube(10), test::moved(test::cube(10), 10, 10, 0)),  // touch along an edge
          mesh::weld(test::joined(test::box(10, 10, 10), test::moved(test::box(10, 10, 10), 10, 10, 0))),
          mesh::weld(test::joined(test::box(10, 10, 10), test::moved(test::box(10, 10, 10), 10, 0, 0))),
          test::joined(test::cube(30), test::moved(test::cube(5), 10, 10, 10))};  // an insert
}

bool same(const TriangleMesh& a, const TriangleMesh& b) {
  return a.triangles == b.triangles && a.vertices.size() == b.vertices.size() &&
         std::equal(a.vertices.begin(), a.vertices.end(), b.vertices.begin(),
                    [](const auto& p, const auto& q) { return p == q; });
}

/// Repairs; checks that a second time changes nothing and that the mesh is closed then.
mesh::RepairReport check_repairs(TriangleMesh& m) {
  const mesh::RepairReport report = mesh::repair(m);
  TriangleMesh again = m;
  CHECK_FALSE(mesh::repair(again).changed());
  CHECK(same(m, again));
  CHECK(mesh::inspect(m).watertight());
  CHECK(report.open_edges_left == 0);
  CHECK(report.changed() == !report.sentences().empty());
  return report;
}

}  // namespace

TEST_CASE("Repair of a sound mesh is the identity") {
  for (const TriangleMesh& sound : sound_meshes()) {
    TriangleMesh m = sound;
    const mesh::RepairReport report = mesh::repair(m);
    CHECK_FALSE(report.changed());
    CHECK(report.sentences().empty());
    CHECK(same(m, sound));
    CHECK(mesh::inspect(sound).flipped_faces == 0);
  }
}

TEST_CASE("Facets that look the wrong way are turned, with the volume as witness") {
  std::mt19937 random(7);
  for (const TriangleMesh& sound : {test::cube(10), test::cup(30, 30, 20, 2, 2), test::sphere(8)}) {
    TriangleMesh m = sound;
    std::size_t turned = 0;
    for (mesh::Triangle& t : m.triangles) {
      if (random() % 4 != 0) continue;
      std::swap(t[1], t[2]);
      ++turned;
    }
    REQUIRE(turned > 0);
    CHECK(mesh::inspect(m).misoriented_edges > 0);
    CHECK(mesh::inspect(m).flipped_faces == turned);
    check_repairs(m);
    CHECK(mesh::volume(m) == Approx(mesh::volume(sound)));
  }
}

TEST_CASE("A file inside out is turned as a whole; its cavity stays a cavity") {
  const TriangleMesh sound = block_with_cavity();
  TriangleMesh m = inside_out(sound);
  CHECK(mesh::inspect(m).flipped_faces == m.triangles.size());
  CHECK(check_repairs(m).shells_inverted == 2);
  CHECK(mesh::volume(m) == Approx(mesh::volume(sound)));
}

TEST_CASE("Of two bodies side by side only the inverted one is turned") {
  TriangleMesh m = test::joined(test::cube(10), inside_out(test::moved(test::cube(10), 20, 0, 0)));
  CHECK(check_repairs(m).shells_inverted == 1);
  CHECK(mesh::volume(m) == Approx(2000));
  // The same when they share an edge, so that its four facets look balanced.
  m = mesh::weld(test::joined(test::cube(10), inside_out(test::moved(test::cube(10), 10, 10, 0))));
  REQUIRE(mesh::inspect(m).non_manifold_edges == 1);
  CHECK(check_repairs(m).shells_inverted == 1);
  CHECK(mesh::volume(m) == Approx(2000));
}

TEST_CASE("Many cavities, some nested, keep their sense and cost little") {
  TriangleMesh m = test::box(210, 210, 30);
  double hollow = 0;
  for (int i = -10; i < 10; ++i) {
    for (int j = -10; j < 10; ++j) {
      const TriangleMesh bubble = test::moved(test::sphere(4, 6, 8), 10 * i + 105, 10 * j + 105, 10);
      m = test::joined(m, inside_out(bubble));
      hollow += mesh::volume(bubble);
    }
  }
  const TriangleMesh pearl = test::moved(test::sphere(2, 6, 8), 105, 105, 12);
  m = test::joined(m, pearl);
  const double solid = 210 * 210 * 30 - hollow + mesh::volume(pearl);
  CHECK(mesh::volume(m) == Approx(solid));
  TriangleMesh same_again = m;
  CHECK_FALSE(mesh::repair(same_again).changed());
  TriangleMesh turned = inside_out(m);
  check_repairs(turned);
  CHECK(mesh::volume(turned) == Approx(solid));
}

TEST_CASE("Corners that miss each other by a hair are joined") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> hair(-2e-4, 2e-4);
  for (const TriangleMesh& sound : {test::cube(30), test::sphere(20, 16, 32), test::comb(5, 4, 3, 10, 2)}) {
    TriangleMesh m = exploded(sound);
    for (mesh::Vec3& v : m.vertices) v += mesh::Vec3(hair(random), hair(random), hair(random));
    CHECK(mesh::inspect(m).open_edges == 3 * m.triangles.size());
    check_repairs(m);
    CHECK(m.triangles.size() == sound.triangles.size());
    CHECK(m.vertices.size() == mesh::weld(sound).vertices.size());
    CHECK(mesh::volume(m) == Approx(mesh::volume(sound)).epsilon(1e-3));
  }
}

TEST_CASE("Facets are cut where vertices of others lie on their sides") {
  // A box whose top is two facets over a side that the wall below divides in four.
  TriangleMesh m = mesh::weld(exploded(test::box(40, 10, 10)));
  const auto side = [](const TriangleMesh& t, std::uint32_t a, std::uint32_t b) {
    return std::abs(t.vertices[a].y() - t.vertices[b].y()) < 1e-9 &&
           std::abs(t.vertices[a].z() - t.vertices[b].z()) < 1e-9;
  };
  bool cut = false;
  for (std::size_t f = 0; f < m.triangles.size() && !cut; ++f) {
    const mesh::Triangle t = m.triangles[f];
    for (std::size_t k = 0; k < 3 && !cut; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3];
      if (!side(m, a, b)) continue;
      cut = true;
      std::uint32_t last = a;
      m.triangles.erase(m.triangles.begin() + static_cast<std::ptrdiff_t>(f));
      for (int i = 1; i <= 4; ++i) {
        std::uint32_t next = b;
        if (i < 4) {
          next = static_cast<std::uint32_t>(m.vertices.size());
          m.vertices.push_back(m.vertices[a] + (m.vertices[b] - m.vertices[a]) * (i / 4.0));
        }
        m.triangles.push_back({last, next, c});
        last = next;
      }
    }
  }
  REQUIRE(cut);
  CHECK(mesh::inspect(m).open_edges == 5);
  const mesh::RepairReport report = check_repairs(m);
  CHECK(report.holes_filled == 0);
  CHECK(report.triangles_added == 3);
  CHECK(mesh::volume(m) == Approx(4000));
  CHECK(mesh::surface_area(m) == Approx(mesh::surface_area(test::box(40, 10, 10))));
}

TEST_CASE("Holes are filled, flat ones exactly") {
  for (const double share : {0.02, 0.1}) {
    const TriangleMesh sound = test::sphere(20, 24, 48);
    TriangleMesh m = sound;
    m.triangles.resize(m.triangles.size() -
                       static_cast<std::size_t>(share * static_cast<double>(m.triangles.size())));
    CHECK(check_repairs(m).holes_filled >= 1);
    CHECK(mesh::volume(m) == Approx(mesh::volume(sound)).epsilon(0.02));
  }
  TriangleMesh cup = test::cup(30, 30, 20, 2, 2);
  const double volume = mesh::volume(cup), surface = mesh::surface_area(cup);
  // The whole floor, inside and outside: two rings.
  std::erase_if(cup.triangles, [&](const mesh::Triangle& t) {
    const mesh::Vec3 a = cup.vertices[t[0]], n = (cup.vertices[t[1]] - a).cross(cup.vertices[t[2]] - a);
    return std::abs(n.z()) > 0.9 * n.norm() && a.z() < 10;
  });
  const mesh::RepairReport report = check_repairs(cup);
  CHECK(report.holes_filled == 2);
  CHECK(mesh::volume(cup) == Approx(volume));
  CHECK(mesh::surface_area(cup) == Approx(surface));
}

TEST_CASE("An open sheet is not made into a part") {
  TriangleMesh m = test::box(20, 20, 20);
  std::erase_if(m.triangles, [&](const mesh::Triangle& t) {
    return m.vertices[t[0]].z() > 1 || m.vertices[t[1]].z() > 1 || m.vertices[t[2]].z() > 1;
  });
  REQUIRE(m.triangles.size() == 2);
  const mesh::RepairReport report = mesh::repair(m);
  CHECK(report.holes_filled == 0);
  CHECK(report.open_edges_left == 4);
}

TEST_CASE("Facets without area and facets given twice are dropped") {
  const TriangleMesh sound = test::cube(10);
  TriangleMesh m = sound;
  m.triangles.push_back(m.triangles[3]);
  m.triangles.push_back({m.triangles[5][1], m.triangles[5][2], m.triangles[5][0]});
  m.triangles.push_back({1, 1, 2});
  m.triangles.push_back({4, 4, 4});
  const mesh::MeshReport before = mesh::inspect(m);
  CHECK(before.duplicate_faces == 2);
  CHECK(before.degenerate_faces == 2);
  const mesh::RepairReport report = check_repairs(m);
  CHECK(report.duplicates_removed == 2);
  CHECK(report.degenerate_removed == 2);
  CHECK(same(m, sound));
  m = sound;
  m.triangles.insert(m.triangles.end(), sound.triangles.begin(), sound.triangles.end());
  CHECK(check_repairs(m).duplicates_removed == 12);
  CHECK(same(m, sound));
}

TEST_CASE("A file with both sides of every face becomes one solid") {
  TriangleMesh m = test::sphere(10);
  const double volume = mesh::volume(m);
  const TriangleMesh other = inside_out(m);
  m.triangles.insert(m.triangles.end(), other.triangles.begin(), other.triangles.end());
  CHECK(std::abs(mesh::volume(m)) < 1e-6);
  CHECK(check_repairs(m).duplicates_removed == other.triangles.size());
  CHECK(mesh::volume(m) == Approx(volume));
}

TEST_CASE("Rubbish is survived, and repairing it twice is repairing it once") {
  for (unsigned seed = 0; seed < 40; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::uniform_int_distribution<std::uint32_t> vertex(0, 12);
    std::uniform_int_distribution<int> place(0, 4);
    TriangleMesh m;
    for (int i = 0; i < 13; ++i) m.vertices.emplace_back(place(random), place(random), place(random));
    for (int i = 0; i < 60; ++i) m.triangles.push_back({vertex(random), vertex(random), vertex(random)});
    m = mesh::weld(m);
    mesh::inspect(m);
    mesh::repair(m);
    for (const mesh::Triangle& t : m.triangles) {
      for (const std::uint32_t v : t) REQUIRE(v < m.vertices.size());
    }
    TriangleMesh again = m;
    CHECK_FALSE(mesh::repair(again).changed());
  }
}

TEST_CASE("A strip with one side only is survived") {
  TriangleMesh m;
  constexpr std::uint32_t kSteps = 40;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double a = 6.283185307179586 * i / kSteps;
    for (const double s : {-1.0, 1.0}) {
      m.vertices.emplace_back((10 + s * std::cos(a / 2)) * std::cos(a),
                              (10 + s * std::cos(a / 2)) * std::sin(a), s * std::sin(a / 2));
    }
    const std::uint32_t j = i + 1;
    const bool last = j == kSteps;
    const std::uint32_t c = last ? 1 : 2 * j, d = last ? 0 : 2 * j + 1;
    m.triangles.push_back({2 * i, c, 2 * i + 1});
    m.triangles.push_back({c, d, 2 * i + 1});
  }
  mesh::repair(m);
  TriangleMesh again = m;
  CHECK_FALSE(mesh::repair(again).changed());
}

TEST_CASE("An empty mesh stays empty") {
  TriangleMesh m;
  CHECK_FALSE(mesh::repair(m).changed());
  CHECK(mesh::inspect(m).triangles == 0);
  CHECK(mesh::inspect(m).watertight());
}

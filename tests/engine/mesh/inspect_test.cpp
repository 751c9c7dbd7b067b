#include "engine/mesh/inspect.h"

#include "engine/mesh/weld.h"
#include "tests/support/meshes.h"

#include <catch2/catch.hpp>

using namespace voidpath;

TEST_CASE("The report of a cube") {
  const mesh::MeshReport r = mesh::inspect(test::cube(10));
  CHECK(r.triangles == 12);
  CHECK(r.vertices == 8);
  CHECK(r.size_mm == mesh::Vec3(10, 10, 10));
  CHECK(r.volume_mm3 == Approx(1000));
  CHECK(r.surface_mm2 == Approx(600));
  CHECK(r.shells == 1);
  CHECK(r.watertight());
  CHECK(r.non_manifold_edges + r.flipped_faces + r.degenerate_faces + r.duplicate_faces == 0);
}

TEST_CASE("Shells hang together over edges, not over corners") {
  const auto two = [](double x, double y, double z) {
    return mesh::inspect(mesh::weld(test::joined(test::cube(10), test::moved(test::cube(10), x, y, z))));
  };
  CHECK(two(30, 0, 0).shells == 2);
  CHECK(two(10, 10, 10).shells == 2);
  const mesh::MeshReport edge = two(10, 10, 0);
  CHECK(edge.shells == 1);
  CHECK(edge.non_manifold_edges == 1);
  CHECK(edge.watertight());
}

TEST_CASE("Open, misoriented and degenerate places are counted") {
  mesh::TriangleMesh m = test::cube(10);
  std::swap(m.triangles[0][0], m.triangles[0][1]);
  mesh::MeshReport r = mesh::inspect(m);
  CHECK(r.misoriented_edges == 3);
  CHECK(r.flipped_faces == 1);
  CHECK_FALSE(r.watertight());
  m.triangles.erase(m.triangles.begin());
  r = mesh::inspect(m);
  CHECK(r.open_edges == 3);
  CHECK(r.flipped_faces == 0);
  m.triangles.push_back({0, 0, 1});
  m.vertices.push_back(0.5 * (m.vertices[0] + m.vertices[1]));
  m.triangles.push_back({0, static_cast<std::uint32_t>(m.vertices.size() - 1), 1});
  CHECK(mesh::inspect(m).degenerate_faces == 2);
}

TEST_CASE("Welding numbers vertices as they are first used and is the identity on its own result") {
  mesh::TriangleMesh soup;
  soup.vertices = {{9, 9, 9}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-0.0, 0.0, -0.0}, {0, 1, 0}, {0, 0, 1}};
  soup.triangles = {{1, 2, 3}, {4, 5, 6}};
  const mesh::TriangleMesh once = mesh::weld(soup);
  REQUIRE(once.vertices.size() == 4);
  CHECK(once.triangles == std::vector<mesh::Triangle>{{0, 1, 2}, {2, 1, 3}});
  const mesh::TriangleMesh twice = mesh::weld(once);
  CHECK(twice.triangles == once.triangles);
  CHECK(std::equal(twice.vertices.begin(), twice.vertices.end(), once.vertices.begin()));
}

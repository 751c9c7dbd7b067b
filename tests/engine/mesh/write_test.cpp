#include "engine/mesh/write.h"

#include "engine/mesh/weld.h"
#include "tests/engine/mesh/import_support.h"
#include "tests/support/meshes.h"

#include <catch2/catch.hpp>

using namespace voidpath;

TEST_CASE("A model written as OBJ comes back bit for bit, as STL within float") {
  const test::TempFolder folder;
  const mesh::TriangleMesh ball = mesh::weld(test::sphere(7.3));
  mesh::write_model(ball, folder.path() / "ball.OBJ");
  const mesh::Import obj = mesh::import_model(folder.path() / "ball.OBJ");
  CHECK(obj.mesh.triangles == ball.triangles);
  CHECK(std::equal(ball.vertices.begin(), ball.vertices.end(), obj.mesh.vertices.begin(),
                   obj.mesh.vertices.end()));
  mesh::write_model(ball, folder.path() / "ball.stl");
  const mesh::Import stl = mesh::import_model(folder.path() / "ball.stl");
  CHECK(stl.format == "stl-binary");
  CHECK(stl.mesh.triangles.size() == ball.triangles.size());
  CHECK(mesh::volume(stl.mesh) == Approx(mesh::volume(ball)).epsilon(1e-6));
  const auto left = std::filesystem::directory_iterator(folder.path());
  CHECK(std::distance(begin(left), end(left)) == 2);
}

TEST_CASE("What cannot be written says so and leaves nothing behind") {
  const test::TempFolder folder;
  CHECK_THROWS_AS(mesh::write_model(test::cube(1), folder.path() / "a.3mf"), std::runtime_error);
  CHECK_THROWS_AS(mesh::write_model(test::cube(1), folder.path() / "none" / "a.stl"), std::runtime_error);
  CHECK(std::filesystem::is_empty(folder.path()));
}

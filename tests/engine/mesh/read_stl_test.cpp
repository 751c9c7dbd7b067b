#include "tests/engine/mesh/import_support.h"
#include "tests/support/meshes.h"

#include <clocale>
#include <cstring>
#include <limits>

#include <catch2/catch.hpp>

using namespace voidpath;
using Catch::Contains;

namespace {

std::string binary_stl(const mesh::TriangleMesh& m, const std::string& header = "made by hand") {
  std::string out(84 + 50 * m.triangles.size(), '\0');
  std::memcpy(out.data(), header.data(), header.size());
  const auto n = static_cast<std::uint32_t>(m.triangles.size());
  std::memcpy(out.data() + 80, &n, 4);
  for (std::size_t f = 0; f < n; ++f) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f p = m.vertices[m.triangles[f][k]].cast<float>();
      std::memcpy(out.data() + 84 + 50 * f + 12 * (k + 1), p.data(), 12);
    }
  }
  return out;
}

std::string ascii_stl(const mesh::TriangleMesh& m, const std::string& end = "\n",
                      const std::string& name = "cube") {
  std::string out = "solid " + name + end;
  for (const mesh::Triangle& t : m.triangles) {
    out += "  facet normal 0 0 0" + end + "    outer loop" + end;
    for (const std::uint32_t v : t) {
      out += "      vertex";
      for (int k = 0; k < 3; ++k) out += " " + std::to_string(m.vertices[v][k]);
      out += end;
    }
    out += "    endloop" + end + "  endfacet" + end;
  }
  return out + "endsolid " + name + end;
}

}  // namespace

TEST_CASE("Binary and ASCII STL of a cube give the same cube") {
  const mesh::TriangleMesh cube = test::cube(10);
  for (const std::string& bytes :
       {binary_stl(cube), ascii_stl(cube), ascii_stl(cube, "\r\n"), ascii_stl(cube, "\r"),
        binary_stl(cube, "solid but binary"), ascii_stl(cube, "\n", "T\xc3\xbcr \xff"),
        ascii_stl(cube) + ascii_stl(mesh::TriangleMesh{})}) {
    const mesh::Import got = test::import_bytes("cube.stl", bytes);
    CHECK(got.mesh.triangles.size() == 12);
    CHECK(got.mesh.vertices.size() == 8);
    CHECK(mesh::volume(got.mesh) == Approx(1000));
    CHECK(got.delivered.watertight());
    CHECK_FALSE(got.repairs.changed());
  }
  CHECK(test::import_bytes("a.stl", binary_stl(cube, "solid but binary")).format == "stl-binary");
  CHECK(test::import_bytes("a.stl", ascii_stl(cube)).format == "stl-ascii");
}

TEST_CASE("The content decides, not the name") {
  CHECK(test::import_bytes("cube.obj", binary_stl(test::cube(10))).format == "stl-binary");
  CHECK(test::import_bytes("cube.txt", ascii_stl(test::cube(10))).format == "stl-ascii");
}

TEST_CASE("Binary STL shorter than it says is refused with both counts and sizes") {
  std::string bytes = binary_stl(test::cube(10));
  bytes.resize(84 + 50 * 7 + 20);
  const std::string why = test::refusal("cut.stl", bytes);
  CHECK_THAT(why, Contains("cut.stl") && Contains("12 facets") && Contains("684 bytes") &&
                      Contains("454 bytes") && Contains("7 whole facets"));
}

TEST_CASE("Bytes after the last facet are passed over, with a note") {
  const mesh::Import got =
      test::import_bytes("more.stl", binary_stl(test::cube(10)) + std::string(17, '\x01'));
  CHECK(got.mesh.triangles.size() == 12);
  REQUIRE(got.notes.size() == 1);
  CHECK_THAT(got.notes[0], Contains("17 bytes"));
}

TEST_CASE("A binary count beyond all measure allocates nothing") {
  std::string bytes = binary_stl(test::cube(10));
  const std::uint32_t huge = 0xffffffffu;
  std::memcpy(bytes.data() + 80, &huge, 4);
  CHECK_THAT(test::refusal("huge.stl", bytes), Contains("4294967295 facets"));
}

TEST_CASE("Empty STL files are refused") {
  CHECK_THAT(test::refusal("a.stl", ""), Contains("empty"));
  CHECK_THAT(test::refusal("a.stl", "solid nothing\nendsolid nothing\n"), Contains("no facets"));
  CHECK_THAT(test::refusal("a.stl", std::string(84, '\0')), Contains("0 facets"));
  CHECK_THAT(test::refusal("a.stl", std::string(30, '\0')), Contains("no STL"));
  CHECK_THAT(test::refusal("a.stl", "<!DOCTYPE html><html><body>404</body></html>"), Contains("<!DOCTYPE"));
}

TEST_CASE("ASCII STL cut inside a facet is refused with the line; without its last line it is accepted") {
  std::string text = ascii_stl(test::cube(10));
  std::string no_end = text.substr(0, text.rfind("endsolid"));
  CHECK(test::import_bytes("a.stl", no_end).mesh.triangles.size() == 12);
  const std::string cut = no_end.substr(0, no_end.rfind("endfacet"));
  CHECK_THAT(test::refusal("a.stl", cut), Contains("line") && Contains("ends inside the facet"));
  text.replace(text.find("vertex") + 7, 8, "12,5 0.0");
  CHECK_THAT(test::refusal("a.stl", text), Contains("line 4") && Contains("'12,5'"));
}

TEST_CASE("Words after a keyword on its line are somebody's remarks") {
  std::string text = ascii_stl(test::cube(10));
  for (std::size_t at = text.find("endloop"); at != text.npos; at = text.find("endloop", at + 8)) {
    text.insert(at + 7, " foo bar");
  }
  CHECK(test::import_bytes("a.stl", text).mesh.triangles.size() == 12);
  text.insert(text.find("facet"), "nonsense\n");
  CHECK_THAT(test::refusal("a.stl", text), Contains("line 2") && Contains("'nonsense'"));
}

TEST_CASE("Numbers are read alike in every locale, exponents and plus signs too") {
  const char* old = std::setlocale(LC_ALL, nullptr);
  const std::string kept = old ? old : "C";
  std::setlocale(LC_ALL, "de_DE.UTF-8");  // where it is installed, 0.5 is written 0,5
  std::string text = ascii_stl(test::cube(10));
  for (std::size_t at = text.find("10.000000"); at != text.npos; at = text.find("10.000000", at)) {
    text.replace(at, 9, "+1.0E+01");
  }
  const mesh::Import got = test::import_bytes("a.stl", text);
  std::setlocale(LC_ALL, kept.c_str());
  CHECK(mesh::volume(got.mesh) == Approx(1000));
}

TEST_CASE("A facet that is not a number is left out and its hole closed; many are refused") {
  const mesh::TriangleMesh ball = test::sphere(10);
  std::string bytes = binary_stl(ball);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto spoil = [&](std::size_t facet) { std::memcpy(bytes.data() + 84 + 50 * facet + 12, &nan, 4); };
  spoil(100);
  const mesh::Import got = test::import_bytes("a.stl", bytes);
  CHECK(got.repairs.holes_filled == 1);
  CHECK(got.repairs.open_edges_left == 0);
  CHECK(mesh::volume(got.mesh) == Approx(mesh::volume(ball)).epsilon(1e-4));
  REQUIRE(got.notes.size() == 1);
  CHECK_THAT(got.notes[0], Contains("facet 101"));
  for (std::size_t f = 0; f < ball.triangles.size(); f += 10) spoil(f);
  CHECK_THAT(test::refusal("a.stl", bytes), Contains("facet 1") && Contains("not a number"));
}

TEST_CASE("Parts of the wrong unit are refused or noted") {
  CHECK_THAT(test::refusal("a.stl", binary_stl(test::cube(1e5))),
             Contains("100000 x 100000") && Contains("unit"));
  const mesh::Import tiny = test::import_bytes("a.stl", binary_stl(test::cube(0.25)));
  REQUIRE(tiny.notes.size() == 1);
  CHECK_THAT(tiny.notes[0], Contains("--scale 25.4"));
  mesh::ImportOptions inches;
  inches.scale = 25.4;
  const mesh::Import scaled = test::import_bytes("a.stl", binary_stl(test::cube(0.25)), inches);
  CHECK(scaled.delivered.size_mm.x() == Approx(6.35));
  CHECK(mesh::volume(scaled.mesh) == Approx(6.35 * 6.35 * 6.35));
}

TEST_CASE("What encloses nothing is refused") {
  mesh::TriangleMesh sheet;
  sheet.vertices = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  CHECK_THAT(test::refusal("a.stl", binary_stl(sheet)), Contains("do not connect") || Contains("no volume"));
  sheet.triangles.push_back({2, 1, 0});
  sheet.triangles.push_back({3, 2, 0});
  CHECK_THAT(test::refusal("a.stl", binary_stl(sheet)), Contains("no volume") || Contains("do not connect"));
  mesh::TriangleMesh point;
  point.vertices = {{1, 1, 1}};
  point.triangles = {{0, 0, 0}, {0, 0, 0}};
  CHECK_THAT(test::refusal("a.stl", binary_stl(point)), Contains("area"));
}

TEST_CASE("Folders, missing files and too many triangles are refused; stopping stops") {
  const test::TempFolder folder;
  CHECK_THROWS_AS(mesh::import_model(folder.path()), mesh::ImportError);
  CHECK_THROWS_AS(mesh::import_model(folder.path() / "none.stl"), mesh::ImportError);
  mesh::ImportOptions few;
  few.max_triangles = 11;
  CHECK_THAT(test::refusal("a.stl", binary_stl(test::cube(10)), few), Contains("more than 11 triangles"));
  few.max_bytes = 100;
  CHECK_THAT(test::refusal("a.stl", binary_stl(test::cube(10)), few), Contains("684 bytes"));
  std::stop_source stop;
  stop.request_stop();
  run::Context ctx;
  ctx.stop = stop.get_token();
  CHECK_THROWS_AS(mesh::import_model(folder.file("a.stl", binary_stl(test::cube(10))), {}, ctx),
                  run::Stopped);
}

TEST_CASE("Names of models") {
  CHECK(mesh::is_model_name("a.STL"));
  CHECK(mesh::is_model_name("dir/b.obj"));
  CHECK(mesh::is_model_name("c.3Mf"));
  CHECK_FALSE(mesh::is_model_name("d.gcode"));
  CHECK_FALSE(mesh::is_model_name(".stl"));
}

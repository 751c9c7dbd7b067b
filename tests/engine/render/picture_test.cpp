#include "engine/render/thumbnail.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath;

namespace {

double covered(const render::Picture& p) {
  double sum = 0;
  for (std::size_t i = 3; i < p.rgba.size(); i += 4) sum += p.rgba[i] / 255.0;
  return sum;
}

}  // namespace

TEST_CASE("a box covers its projected area, centred, as large as the picture holds") {
  const double a = 30, b = 20, c = 10;
  const auto mesh = test::box(a, b, c);
  const render::Picture p = render::draw(mesh, 300, 200);
  REQUIRE(p.rgba.size() == 300 * 200 * 4);
  // The eye's direction is (sin 30 cos 30, -cos 30 cos 30, sin 30): each face shows by its share of it.
  const double shown = b * c * 0.4330127 + a * c * 0.75 + a * b * 0.5;
  const double width = a * 0.8660254 + b * 0.5;
  const double height = (a * 0.5 + b * 0.8660254) * 0.5 + c * 0.8660254;
  const double scale = 0.92 * std::min(300 / width, 200 / height);
  CHECK(covered(p) == Approx(shown * scale * scale).epsilon(0.01));
  // Three faces, three shades.
  std::set<std::uint8_t> shades;
  for (std::size_t i = 0; i < p.rgba.size(); i += 4)
    if (p.rgba[i + 3] == 255) shades.insert(p.rgba[i + 1]);
  CHECK(shades.size() >= 3);
  const auto at = [&](int x, int y) { return p.rgba[static_cast<std::size_t>((y * 300 + x) * 4 + 3)]; };
  CHECK(at(150, 100) == 255);
  CHECK(at(0, 0) == 0);
}

TEST_CASE("what is nearer hides what is behind, whatever the order") {
  mesh::TriangleMesh mesh = test::box(20, 20, 20);
  mesh::TriangleMesh back = mesh;
  std::reverse(back.triangles.begin(), back.triangles.end());
  CHECK(render::draw(mesh, 64, 64).rgba == render::draw(back, 64, 64).rgba);
}

TEST_CASE("a thumbnail is a PNG in short comment lines") {
  const auto picture = render::draw(test::box(10, 10, 10), 32, 32);
  const std::string bytes = render::png(picture);
  CHECK(bytes.rfind("\x89PNG\r\n\x1a\n", 0) == 0);
  std::istringstream text(render::thumbnail(picture));
  std::string line;
  std::getline(text, line);
  const std::string size = std::to_string((bytes.size() + 2) / 3 * 4);
  CHECK(line == "thumbnail begin 32x32 " + size);
  std::string base64;
  while (std::getline(text, line) && line != "thumbnail end") {
    CHECK(line.size() <= 78);
    base64 += line;
  }
  CHECK(line == "thumbnail end");
  CHECK(std::to_string(base64.size()) == size);
  CHECK(base64.rfind("iVBORw0KGgo", 0) == 0);
}

TEST_CASE("sizes of pictures are read or refused by name") {
  CHECK(render::picture_size("400x300") == std::pair{400, 300});
  for (const char* bad : {"", "400", "400x", "x300", "0x10", "10x2000", "10x10x10", "-4x4", "4 x4"})
    CHECK_THROWS_WITH(render::picture_size(bad), Catch::Contains("no picture size"));
}

#include "tests/engine/mesh/import_support.h"

#include <chrono>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using Catch::Contains;

namespace {

const std::string kCubeVertices =
    "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 0 0 10\nv 10 0 10\nv 10 10 10\nv 0 10 10\n";
const std::string kCubeFaces = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

void check_cube(const std::string& text) {
  INFO(text);
  const mesh::Import got = test::import_bytes("cube.obj", text);
  CHECK(got.format == "obj");
  CHECK(got.mesh.triangles.size() == 12);
  CHECK(got.mesh.vertices.size() == 8);
  CHECK(mesh::volume(got.mesh) == Approx(1000));
  CHECK_FALSE(got.repairs.changed());
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != text.npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// A prism of height 1 over the ring, walls and lids as n-gons.
std::string prism(const std::vector<std::pair<double, double>>& ring) {
  std::string out;
  const std::size_t n = ring.size();
  for (const int z : {0, 1}) {
    for (const auto& [x, y] : ring) {
      out += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(z) + "\n";
    }
  }
  std::string bottom = "f", top = "f";
  for (std::size_t i = 0; i < n; ++i) {
    bottom += " " + std::to_string(n - i);
    top += " " + std::to_string(n + i + 1);
    const std::size_t j = (i + 1) % n;
    out += "f " + std::to_string(i + 1) + " " + std::to_string(j + 1) + " " + std::to_string(n + j + 1) +
           " " + std::to_string(n + i + 1) + "\n";
  }
  return out + bottom + "\n" + top + "\n";
}

double ring_area(const std::vector<std::pair<double, double>>& ring) {
  double twice = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const auto& [x, y] = ring[i];
    const auto& [u, v] = ring[(i + 1) % ring.size()];
    twice += x * v - u * y;
  }
  return twice / 2;
}

}  // namespace

TEST_CASE("OBJ cubes in every spelling are the same cube") {
  const std::string plain = kCubeVertices + kCubeFaces;
  check_cube(plain);
  check_cube(replaced(plain, "\n", "\r\n"));
  check_cube(replaced(plain, "\n", "\r"));
  check_cube(plain.substr(0, plain.size() - 1));
  check_cube("\xef\xbb\xbf# mark\nmtllib ../../etc/passwd\no x\ng y\ns off\nusemtl z\n" + plain +
             "l 1 2\np 3\n");
  check_cube(kCubeFaces + kCubeVertices);
  check_cube(replaced(kCubeVertices, "\n", " nan nan nan\n") + kCubeFaces);
  check_cube(kCubeVertices + "vt 0 0\nvn 0 0 1\n" + replaced(replaced(kCubeFaces, " ", " 0"), "f ", "f  "));
  check_cube(kCubeVertices +
             "vt 0 0\nvn 0 0 1\nf 4/1/1 3/1/1 2/1/1 1/1/1\nf 5//1 6//1 7//1 8//1\nf 1/1 2/1 6/1 5/1\n"
             "f 2 3 7 \\\n 6\nf 3 \\  \n4 8 7\nf -5 -8 -4 -1 # back\n");
}

TEST_CASE("OBJ damage is refused with its line") {
  CHECK_THAT(test::refusal("a.obj", kCubeVertices + "f 1 2 9\n"),
             Contains("a.obj: line 9") && Contains("vertex 9"));
  CHECK_THAT(test::refusal("a.obj", kCubeVertices + "f 1 2 0\n"), Contains("line 9") && Contains("vertex 0"));
  CHECK_THAT(test::refusal("a.obj", kCubeVertices + "f 1 2 -9\n"), Contains("line 9") && Contains("-9"));
  CHECK_THAT(test::refusal("a.obj", kCubeVertices + "f 1 2 99999999999999999999\n"), Contains("line 9"));
  CHECK_THAT(test::refusal("a.obj", kCubeVertices + "f 1 two 3\n"), Contains("line 9") && Contains("'two'"));
  CHECK_THAT(test::refusal("a.obj", kCubeVertices + "f 1 2\n"), Contains("line 9") && Contains("2 corners"));
  CHECK_THAT(test::refusal("a.obj", "v 1 2\n"), Contains("line 1") && Contains("three coordinates"));
  CHECK_THAT(test::refusal("a.obj", "v 1 2 x\n"), Contains("line 1") && Contains("'x'"));
  CHECK_THAT(test::refusal("a.obj", "v 0 0 0\r\nv 1 nan 2\r\n"),
             Contains("line 2") && Contains("not a number"));
  CHECK_THAT(test::refusal("a.obj", "v 1 1e999 2\n"), Contains("line 1"));
  CHECK_THAT(test::refusal("a.obj", kCubeVertices), Contains("no faces") && Contains("8 vertices"));
}

TEST_CASE("UTF-16 text is refused in words, with a byte order mark and without") {
  std::string wide;
  for (const char c : kCubeVertices + kCubeFaces) {
    wide += c;
    wide += '\0';
  }
  CHECK_THAT(test::refusal("a.obj", wide), Contains("UTF-16"));
  CHECK_THAT(test::refusal("a.obj", "\xff\xfe" + wide), Contains("UTF-16"));
}

TEST_CASE("Concave faces are cut inside their outline") {
  // A star, and a comb whose teeth a fan would cut across.
  std::vector<std::pair<double, double>> star, comb = {{0, 0}, {20, 0}};
  for (int i = 0; i < 10; ++i) {
    const double r = i % 2 == 0 ? 10 : 3, a = i * 3.14159265358979 / 5;
    star.emplace_back(r * std::cos(a), r * std::sin(a));
  }
  for (int i = 10; i-- > 0;) {
    comb.insert(comb.end(), {{2 * i + 2, 10}, {2 * i + 1, 10}, {2 * i + 1, 1}, {2 * i, 1}});
  }
  for (const auto& ring : {star, comb}) {
    const mesh::Import got = test::import_bytes("a.obj", prism(ring));
    CHECK(mesh::volume(got.mesh) == Approx(ring_area(ring)).epsilon(1e-5));
    // Facets that overlap would add to the surface.
    double around = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const auto& p = ring[i];
      const auto& q = ring[(i + 1) % ring.size()];
      around += std::hypot(q.first - p.first, q.second - p.second);
    }
    CHECK(got.delivered.surface_mm2 == Approx(2 * ring_area(ring) + around).epsilon(1e-5));
    CHECK(got.delivered.watertight());
  }
}

TEST_CASE("A face of very many corners takes no time to speak of") {
  std::vector<std::pair<double, double>> comb = {{0, 0}, {200, 0}};
  constexpr int kTeeth = 2500;
  for (int i = kTeeth; i-- > 0;) {
    const double x = 200.0 * i / kTeeth, w = 200.0 / kTeeth;
    comb.insert(comb.end(), {{x + w, 10}, {x + 0.5 * w, 10}, {x + 0.5 * w, 1}, {x, 1}});
  }
  const auto begin = std::chrono::steady_clock::now();
  const mesh::Import got = test::import_bytes("a.obj", prism(comb));
  CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(60));
  CHECK(got.mesh.triangles.size() > 30000);
}

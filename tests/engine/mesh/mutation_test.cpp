#include "engine/mesh/write.h"
#include "tests/engine/mesh/import_support.h"
#include "tests/support/meshes.h"

#include <cstdlib>
#include <random>
#include <sstream>

#include <catch2/catch.hpp>

using namespace voidpath;

namespace {

std::string contents(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

std::string threemf_of(const mesh::TriangleMesh& m) {
  std::string model =
      "<model xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources><object "
      "id=\"1\">"
      "<mesh><vertices>";
  for (const mesh::Vec3& v : m.vertices) {
    model += "<vertex x=\"" + std::to_string(v.x()) + "\" y=\"" + std::to_string(v.y()) + "\" z=\"" +
             std::to_string(v.z()) + "\"/>";
  }
  model += "</vertices><triangles>";
  for (const mesh::Triangle& t : m.triangles) {
    model += "<triangle v1=\"" + std::to_string(t[0]) + "\" v2=\"" + std::to_string(t[1]) + "\" v3=\"" +
             std::to_string(t[2]) + "\"/>";
  }
  model += "</triangles></mesh></object></resources><build><item objectid=\"1\"/></build></model>";
  const std::string rels =
      "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\"><Relationship "
      "Target=\"/m\" Id=\"r\" Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>"
      "</Relationships>";
  return test::zip({{"_rels/.rels", rels}, {"m", model}});
}

std::string ascii_stl_of(const mesh::TriangleMesh& m) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << "solid x\n";
  for (const mesh::Triangle& t : m.triangles) {
    out << "facet normal 0 0 1\nouter loop\n";
    for (const std::uint32_t v : t) out << "vertex " << m.vertices[v].transpose() << '\n';
    out << "endloop\nendfacet\n";
  }
  out << "endsolid\n";
  return out.str();
}

/// Bytes changed, pieces doubled, dropped or moved.
std::string mutated(std::string s, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::size_t{random()} % std::max<std::size_t>(n, 1); };
  for (std::size_t i = 1 + below(4); i-- > 0 && !s.empty();) {
    const std::size_t at = below(s.size()), length = 1 + below(60);
    switch (below(6)) {
      case 0:
        s[at] = static_cast<char>(below(256));
        break;
      case 1:
        s[at] = "0123456789-+.eE/\\ \n<>\"&#"[below(24)];
        break;
      case 2:
        s.erase(at, length);
        break;
      case 3:
        s.insert(at, s.substr(below(s.size()), length));
        break;
      case 4:
        s.resize(at);
        break;
      default:
        s.replace(at, 1, std::string(1 + below(4), static_cast<char>(0xff)));
        break;
    }
  }
  return s;
}

}  // namespace

TEST_CASE("Damaged files are refused or give a valid mesh, and nothing else happens") {
  const test::TempFolder folder;
  const mesh::TriangleMesh ball = test::sphere(10, 5, 7);
  mesh::write_model(ball, folder.path() / "a.stl");
  mesh::write_model(ball, folder.path() / "a.obj");
  const std::vector<std::pair<std::string, std::string>> files = {
      {"f.stl", contents(folder.path() / "a.stl")},
      {"f.stl", ascii_stl_of(ball)},
      {"f.obj", contents(folder.path() / "a.obj")},
      {"f.3mf", threemf_of(ball)}};
  // More rounds by hand: VOIDPATH_MUTATIONS=100000.
  const char* asked = std::getenv("VOIDPATH_MUTATIONS");
  const unsigned rounds = asked ? static_cast<unsigned>(std::atoi(asked)) : 400;
  std::size_t accepted = 0, refused = 0;
  for (const auto& [name, whole] : files) {
    REQUIRE(mesh::import_model(folder.file(name, whole)).delivered.watertight());
    for (unsigned seed = 0; seed < rounds; ++seed) {
      std::mt19937 random(seed);
      const std::string bytes = mutated(whole, random);
      INFO(name << " seed " << seed);
      try {
        mesh::ImportOptions options;
        options.max_triangles = 10'000;
        const mesh::Import got = mesh::import_model(folder.file(name, bytes), options);
        bool valid = !got.mesh.triangles.empty() && mesh::volume(got.mesh) > 0;
        for (const mesh::Vec3& v : got.mesh.vertices) valid = valid && v.allFinite();
        for (const mesh::Triangle& t : got.mesh.triangles) {
          for (const std::uint32_t v : t) valid = valid && v < got.mesh.vertices.size();
        }
        CHECK(valid);
        ++accepted;
      } catch (const mesh::ImportError& e) {
        CHECK(std::string(e.what()).starts_with(name + ": "));
        ++refused;
      }
    }
  }
  CHECK(accepted > 0);
  CHECK(refused > 0);
}

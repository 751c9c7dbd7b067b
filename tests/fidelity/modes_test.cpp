#include "tests/fidelity/modes.h"

#include "engine/mesh/import.h"
#include "tests/fidelity/shapes.h"

#include <cstdlib>
#include <filesystem>
#include <iostream>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::fidelity;
namespace fs = std::filesystem;

namespace {

struct Shape {
  const char* name;
  mesh::TriangleMesh mesh;
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> all = {
      {"spool", spool()}, {"ball", ball()}, {"beaker", beaker()}, {"drilled", drilled()}};
  return all;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("each way of slicing prints the part, layer by layer") {
  for (const Mode& m : modes())
    for (const Shape& shape : shapes()) {
      if (!m.suits(shape.name)) continue;
      const Sliced part = sliced(shape.mesh, options_for(m.set));
      const Findings f = checked(part);
      INFO(told(m.name + ", " + shape.name, f));
      CHECK(f.layers > 10);
      CHECK(f.length_mm > 500);
      CHECK(beyond_bounds(f, m.bounds(part.rules)) == Names{});
    }
}

TEST_CASE("each way of slicing gives the same bytes on one thread and on many") {
  for (const Mode& m : modes()) {
    const Shape& shape = shapes()[m.suits("spool") ? 0 : 2];
    run::Context one, many;
    one.threads = 1;
    many.threads = 5;
    const auto options = options_for(m.set);
    CAPTURE(m.name);
    CHECK((sliced(shape.mesh, options, one).gcode == sliced(shape.mesh, options, many).gcode));
  }
}

TEST_CASE("real parts, sliced in every way", "[.every]") {
  const std::string shared = test::shared_dir();
  REQUIRE(!shared.empty());
  const char* only = std::getenv("VOIDPATH_ONLY");  // part of a name; empty: all
  const char* one_mode = std::getenv("VOIDPATH_MODE");
  for (const char* name :
       {"calibration-shapes__SupportTest.stl", "calibration-shapes__HollowCalibrationCube.stl",
        "prusaslicer__bunny.stl", "superslicer__extruder_idler.obj", "mendel90__z_coupling.stl",
        "dotscad_drilled_cube.stl", "original-prusa-i3__fan-shroud.stl", "meshes__cat-low-resolution.obj",
        "dotscad_superformula_vase.stl"}) {
    if (only != nullptr && std::string(name).find(only) == std::string::npos) continue;
    const mesh::TriangleMesh mesh = mesh::import_model(fs::path(shared) / "models" / name, {}, {}).mesh;
    for (const Mode& m : modes()) {
      if (one_mode != nullptr && m.name.find(one_mode) == std::string::npos) continue;
      const Sliced part = sliced(mesh, options_for(m.set));
      const Findings f = checked(part);
      const Names beyond = beyond_bounds(f, m.bounds(part.rules));
      std::cout << told(std::string(name) + ", " + m.name, f);
      for (const std::string& b : beyond) std::cout << "  BEYOND " << b << "\n";
      std::cout << std::flush;
      INFO(told(std::string(name) + ", " + m.name, f));
      CHECK(beyond == Names{});
    }
  }
}

#include "tests/fidelity/modes.h"

#include "tests/fidelity/shapes.h"
#include "tests/fidelity/survey.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <stdexcept>

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
  static const std::vector<Shape> all = {{"spool", spool()},
                                         {"ball", ball()},
                                         {"beaker", beaker()},
                                         {"drilled", drilled()},
                                         {"finned", finned()}};
  return all;
}

using Names = std::vector<std::string>;

/// Those whose name holds `part`: of some small ones, since each is looked at some twenty times; of all,
/// where none of these is meant.
std::vector<test::RealModel> models_for(const fs::path& folder, const std::string& part) {
  std::vector<test::RealModel> out;
  for (const char* name :
       {"mendel90__z_coupling.stl", "calibration-shapes__HollowCalibrationCube.stl", "superslicer__A.obj",
        "3d-printing__Ritzel.stl", "numpy-stl__bwb.stl", "original-prusa-i3__fan-shroud.stl",
        "rpg-scad__gnome.stl", "calibration-shapes__SupportTest.stl", "dotscad_drilled_cube.stl"})
    if (std::string(name).find(part) != std::string::npos) out.push_back(test::real_model(folder / name));
  return out.empty() ? test::real_models(folder, part) : out;
}

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

TEST_CASE("compensation that was asked for is there, and none that was not") {
  const auto with = [](const char* name) { return sliced(drilled(), options_for(mode(name).set)); };
  // Walls lie on their outline, in the mean to a seventh of the least compensation.
  for (const char* name : {"larger", "smaller, wider holes", "elephant foot"}) {
    const Findings f = checked(with(name));
    INFO(told(name, f));
    CHECK(f.inset.value <= 0.02);
  }
  Sliced larger = with("larger"), smaller = with("smaller, wider holes"), foot = with("elephant foot");
  larger.rules.outer_growth = 0;
  CHECK(checked(larger).outside.value > 0.13);
  smaller.rules.outer_growth = 0;
  CHECK(checked(smaller).inset.value > 0.1);
  smaller.rules.outer_growth = -0.15;
  smaller.rules.hole_growth = 0;
  // The hole's border is a quarter of all there is.
  CHECK(checked(smaller).inset.value > 0.05);
  foot.rules.foot = 0;
  CHECK(checked(foot).inset.value > 0.15);
}

TEST_CASE("brims reach as far as they are to, and not into the part") {
  const Sliced brim = sliced(drilled(), options_for(mode("brim").set));
  const Findings f = checked(brim);
  INFO(told("brim", f));
  CHECK(f.brim_mm > 300);
  CHECK(f.brim_away.value > 2);
  CHECK(f.brim_away.value <= 3.1);
  const Findings ears = checked(sliced(drilled(), options_for(mode("ears").set)));
  INFO(told("ears", ears));
  CHECK(ears.brim_mm > 50);
  CHECK(ears.brim_mm < f.brim_mm);
  CHECK(ears.brim_away.value <= 4.1);
}

TEST_CASE("support that begins in the air is seen, in either style") {
  for (const char* style : {"grid", "tree"}) {
    Sliced part = sliced(spool(), options_for({{"slice.support_style", style}}));
    const Findings good = checked(part);
    INFO(told(style, good));
    CHECK(good.support_mm > 300);
    CHECK(beyond_bounds(good, bounds_for(part.rules)) == Names{});
    // One layer of support that is not pressed out leaves the next one without anything below.
    std::istringstream in(part.gcode);
    std::string line, type, cut;
    for (int layer = -1; std::getline(in, line);) {
      if (line == ";LAYER_CHANGE") ++layer;
      if (line.rfind(";TYPE:", 0) == 0) type = line.substr(6);
      const bool drop = layer == 15 && type.rfind("Support", 0) == 0 && line.rfind("G1 X", 0) == 0;
      cut += (drop ? line.substr(0, line.find(" E")) : line) + "\n";
    }
    part.gcode = std::move(cut);
    const Findings bad = checked(part);
    CHECK(std::max(bad.support_loose.value, bad.support_span.value) > 2);
  }
}

TEST_CASE("support from the plate alone is asked for where the plate can give it, and only there") {
  for (const char* style : {"grid", "tree"}) {
    const Set set{{"slice.support_style", style}, {"slice.support", "plate"}};
    // A spool's cap reaches beyond its foot, another's does not.
    const auto other = test::joined(spool(), test::moved(test::box(17, 14, 1.6), -8.5, -7, 0));
    for (const bool in_reach : {true, false}) {
      if (!in_reach && set.front().second == "tree") continue;  // it is the same place
      Sliced part = sliced(in_reach ? spool() : other, options_for(set));
      std::istringstream in(part.gcode);
      std::string line, type, cut;
      while (std::getline(in, line)) {
        if (line.rfind(";TYPE:", 0) == 0) type = line.substr(6);
        const bool drop =
            type.rfind("Support", 0) == 0 && (line.rfind("G1 X", 0) == 0 || line.rfind("G1 Y", 0) == 0);
        cut += (drop ? line.substr(0, line.find(" E")) : line) + "\n";
      }
      part.gcode = std::move(cut);
      const Findings f = checked(part);
      INFO(told(style, f));
      CHECK((std::max(f.loose.value, f.unannounced.value) > 2) == in_reach);
    }
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
  std::vector<Case> cases;
  for (const test::RealModel& model : models_for(fs::path(shared) / "models", only != nullptr ? only : "")) {
    const std::string name = model.file.filename().string();
    const auto mesh = std::make_shared<const mesh::TriangleMesh>(imported(model));
    for (const Mode& m : modes()) {
      if (one_mode != nullptr && m.name.find(one_mode) == std::string::npos) continue;
      // Each way is a line of its own in the summary.
      cases.push_back(
          {name + ", " + m.name, "", mesh, m.set, [&m](const Rules& rules) { return m.bounds(rules); }});
    }
  }
  const std::vector<Verdict> verdicts = survey(cases, std::cout);
  CHECK(all_within(verdicts));
  std::cout << summary(verdicts) << std::flush;
}

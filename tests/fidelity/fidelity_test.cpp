#include "engine/mesh/import.h"
#include "tests/fidelity/survey.h"
#include "tests/support/meshes.h"
#include "tests/support/real_models.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::fidelity;
namespace fs = std::filesystem;

TEST_CASE("what is printed is the part, layer by layer") {
  const std::pair<const char*, mesh::TriangleMesh> shapes[] = {
      {"cube", test::cube(15)},
      {"cylinder", test::cylinder(8, 6)},
      {"cup", test::cup(18, 14, 8, 1.1, 1.4)},
      {"comb", test::comb(3, 2, 3, 6, 2)},
      {"table", test::table(20, 15, 6, 2, 3)},
      {"sphere", test::sphere(8, 24, 40)},
  };
  const Set sets[] = {{},
                      {{"slice.infill_density", "1"}},
                      {{"slice.infill_pattern", "gyroid"}, {"slice.perimeters", "3"}},
                      {{"slice.infill_pattern", "grid"}, {"slice.layer_height_mm", "0.28"}},
                      {{"slice.external_perimeters_first", "true"}, {"slice.infill_pattern", "concentric"}}};
  for (const auto& [name, mesh] : shapes)
    for (const Set& set : sets) {
      const Sliced part = sliced(mesh, options_for(set));
      const Findings f = checked(part);
      INFO(told(name, f));
      CHECK(f.layers > 10);
      CHECK(f.length_mm > 500);
      CHECK(beyond_bounds(f, bounds_for(part.rules)) == std::vector<std::string>{});
    }
}

TEST_CASE("the checker sees what is wrong") {
  const Sliced good = sliced(test::table(20, 15, 6, 2, 3), options_for({}));
  // Each edit stands for a mistake a slicer can make; it gets a line of G-code, the layer and the type.
  const auto edited = [&](auto&& edit) {
    Sliced bad = good;
    bad.gcode.clear();
    std::istringstream in(good.gcode);
    std::string line, type;
    int layer = -1;
    while (std::getline(in, line)) {
      if (line == ";LAYER_CHANGE") ++layer;
      if (line.rfind(";TYPE:", 0) == 0) type = line.substr(6);
      bad.gcode += edit(line, layer, type) + "\n";
    }
    return checked(bad);
  };
  const auto dry = [](std::string line) { return line.substr(0, line.find(" E")); };

  const Findings open_top = edited([&](const std::string& line, int layer, const std::string& type) {
    return layer == 29 && type == "Top solid infill" ? dry(line) : line;
  });
  CHECK(open_top.top_hole.value > 1);
  CHECK(open_top.bottom_hole.value <= hole_limit(open_top));

  const Findings open_bottom = edited([&](const std::string& line, int layer, const std::string& type) {
    return layer == 0 && type == "Solid infill" ? dry(line) : line;
  });
  CHECK(open_bottom.bottom_hole.value > 0.3);

  const Findings no_support = edited([&](const std::string& line, int, const std::string& type) {
    return type.rfind("Support", 0) == 0               ? dry(line)
           : type == "Bridge infill" && line[0] == ';' ? ";TYPE:Solid infill"
                                                       : line;
  });
  CHECK(no_support.unannounced.value + no_support.loose.value > 5);

  const Findings missing_layer = edited(
      [&](const std::string& line, int layer, const std::string&) { return layer == 10 ? dry(line) : line; });
  CHECK(missing_layer.loose.value > 3);

  const Findings fat = edited([&](const std::string& line, int, const std::string& type) {
    const std::size_t e = line.find(" E");
    if (type != "External perimeter" || line.rfind("G1 ", 0) != 0 || e == std::string::npos ||
        line[e + 2] == '-')
      return line;
    return line.substr(0, e) + " E" + std::to_string(2 * std::stod(line.substr(e + 2)));
  });
  CHECK(fat.outside.value > outside_limit(fat));
  CHECK(fat.volume_ratio > 1.05);
}

TEST_CASE("what is thinner than a pixel of the checker is part of the part") {
  mesh::TriangleMesh mesh = test::box(4, 4, 2);
  for (const double x : {8.0, 9.07, 10.13, 11.19})
    mesh = test::joined(mesh, test::moved(test::box(0.08, 4, 2), x, 0, 0));
  Sliced part = sliced(mesh, options_for({}));
  part.rules.largest_pixel = 0.2;
  const Findings f = checked(part);
  INFO(told("blades", f));
  REQUIRE(f.pixel > 0.19);
  CHECK(f.outside.value <= outside_limit(f));
}

TEST_CASE("real parts are printed as they are", "[corpus]") {
  const std::string shared = test::shared_dir();
  if (shared.empty()) {
    WARN("VOIDPATH_SHARED is not set: skipped");
    return;
  }
  for (const char* name : {"rpg-scad__gnome.stl", "rpg-scad__comb_13.stl"}) {
    const fs::path file = fs::path(shared) / "models" / name;
    if (!fs::exists(file)) continue;
    const Findings f = checked(sliced(mesh::import_model(file, {}, {}).mesh, options_for({})));
    INFO(told(name, f));
    CHECK(f.outside.value <= 0.2);
    CHECK(f.top_hole.value <= hole_limit(f));
    CHECK(f.bottom_hole.value <= hole_limit(f));
    CHECK(f.loose.value <= kTip);
    CHECK(f.unannounced.value <= kTip);
    CHECK(f.volume_ratio == Approx(1).margin(0.02));
  }
}

TEST_CASE("a survey tells what is beyond its bounds, and by how much at worst") {
  const auto shape = std::make_shared<const mesh::TriangleMesh>(test::table(12, 9, 4, 2, 2));
  const auto strict = [](const Rules& rules) {
    Bounds b = bounds_for(rules);
    b.support_span = -1;
    return b;
  };
  const std::vector<Case> cases = {{"table", "", shape, {}},
                                   {"bad", "", shape, {}, strict},
                                   {"bad", "rough", shape, {{"slice.layer_height_mm", "0.3"}}, strict},
                                   {"none", "", std::make_shared<const mesh::TriangleMesh>(), {}}};
  std::ostringstream out;
  const std::vector<Verdict> verdicts = survey(cases, out);
  REQUIRE(verdicts.size() == cases.size());
  CHECK(verdicts[0].beyond.empty());
  REQUIRE(verdicts[1].beyond.size() == 1);
  CHECK(verdicts[1].beyond[0].name == "support span");
  CHECK(verdicts[2].way == "rough");
  CHECK(verdicts[3].beyond.size() == 1);  // nothing to slice
  CHECK(out.str().find("bad, rough: ") != std::string::npos);

  const std::string text = summary({{"a", "", {}},
                                    {"a", "solid", {}},
                                    {"b", "", {{"loose", 0.8, 0.5, "layer 3"}}},
                                    {"b", "solid", {{"loose", 1.2, 0.5, "layer 7"}, {"odd line", 0, 0, ""}}},
                                    {"c", "", {{"outside", 0.2, 0.125, "layer 1"}}}});
  CHECK(text ==
        "1 of 3 parts within bounds (2 of 5 prints)\n"
        "  b: solid: loose 1.2 of 0.5 layer 7; solid: odd line\n"
        "  c: outside 0.2 of 0.125 layer 1\n");
}

TEST_CASE("every real part, printed sparse and solid", "[.every]") {
  const std::string shared = test::shared_dir();
  REQUIRE(!shared.empty());
  const char* only = std::getenv("VOIDPATH_ONLY");  // part of a name; empty: all
  std::vector<Case> cases;
  for (const auto& model : test::real_models(fs::path(shared) / "models", only != nullptr ? only : "")) {
    const auto mesh = std::make_shared<const mesh::TriangleMesh>(imported(model));
    const std::string name = model.file.filename().string();
    cases.push_back({name, "", mesh, {}});
    cases.push_back({name, "solid", mesh, {{"slice.infill_density", "1"}}});
  }
  const std::vector<Verdict> verdicts = survey(cases, std::cout);
  CHECK(all_within(verdicts));
  std::cout << summary(verdicts) << std::flush;
}

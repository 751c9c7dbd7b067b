#include "engine/mesh/write.h"
#include "tests/e2e/bench_rig.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>

using namespace voidpath::test;
namespace fs = std::filesystem;
namespace mesh = voidpath::mesh;

namespace {

const char* const kProfile =
    "layer_height = 0.25\nfirst_layer_height = 0.25\nnozzle_diameter = 0.4\nperimeters = 2\n"
    "bed_shape = 0x0,220x0,220x220,0x220\nmax_print_height = 250\ngcode_flavor = marlin2\n"
    "use_relative_e_distances = 1\nlayer_gcode = G92 E0\nstart_gcode = G28\\nM117 by another slicer\n";

/// One square, one layer, around the middle of a bed of 220 mm; the first time it is asked for, it fails.
const char* const kOnceBroken =
    "#!/bin/sh\n"
    "while [ $# -gt 0 ]; do [ \"$1\" = --output ] && out=$2; shift; done\n"
    "[ -e \"$0.tried\" ] || { : > \"$0.tried\"; echo 'the licence has run out'; exit 9; }\n"
    "echo 'a word from the slicer'\n"
    "printf 'G28\\nM83\\nM109 S200\\nM117 by another slicer\\n;LAYER_CHANGE\\n;Z:0.2\\nG1 X104 Y104 Z0.2 "
    "F3000\\n' > "
    "\"$out\"\n"
    "printf 'G1 X116 E1 F1200\\nG1 Y116 E1\\nG1 X104 E1\\nG1 Y104 E1\\n' >> \"$out\"\n";

std::string config_for(const fs::path& program, const fs::path& profile) {
  return "slicer: prusa-slicer\nprusa_slicer: {program: \"" + program.string() + "\", profile: \"" +
         profile.string() + "\"}\n";
}

bool installed(const std::string& name) {
  const std::string path = std::getenv("PATH") != nullptr ? std::getenv("PATH") : "";
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t colon = std::min(path.find(':', begin), path.size());
    if (fs::exists(fs::path(path.substr(begin, colon - begin)) / name)) return true;
    begin = colon + 1;
  }
  return false;
}

}  // namespace

TEST_CASE("a job whose slicer fails is failed with its words, and prints when it is tried again") {
  const ScratchDir dir;
  std::ofstream(dir / "slicer") << kOnceBroken;
  fs::permissions(dir / "slicer", fs::perms::owner_all);
  std::ofstream(dir / "mine.ini") << kProfile;
  mesh::write_model(box(12, 12, 6), dir / "cube.stl");
  BenchRig::Options options;
  options.extra_config = config_for(dir / "slicer", dir / "mine.ini");
  BenchRig rig(options);
  rig.start_mock();
  rig.start_daemon();
  REQUIRE(rig.cli({"add", dir / "cube.stl"}).code == 0);
  REQUIRE(eventually([&] { return fs::exists(rig.inbox() / "failed/cube.stl"); }));
  CHECK(rig.cli({"logs"}).out.find("the licence has run out") != std::string::npos);
  REQUIRE(rig.cli({"retry", "1"}).code == 0);
  REQUIRE(eventually([&] { return fs::exists(rig.inbox() / "done/cube.stl"); }));
  CHECK(rig.cli({"logs"}).out.find("a word from the slicer") != std::string::npos);
  // The built-in one is there for who asks.
  REQUIRE(rig.cli({"add", dir / "cube.stl", "--slicer", "builtin"}).code == 0);
  std::vector<int> layers;
  REQUIRE(eventually([&] {
    layers.clear();
    for (const auto& row : rig.history())
      if (row.at("state") == "done") layers.push_back(row.at("layers"));
    return layers.size() == 2;
  }));
  std::sort(layers.begin(), layers.end());
  CHECK(layers == std::vector<int>{1, 30});
}

TEST_CASE("the real PrusaSlicer's G-code is what is printed") {
  if (!installed("prusa-slicer")) {
    WARN("skipped: PrusaSlicer is not installed");
    return;
  }
  const ScratchDir dir;
  std::ofstream(dir / "mine.ini") << kProfile;
  BenchRig::Options options;
  options.extra_config = config_for("prusa-slicer", dir / "mine.ini");
  BenchRig rig(options);
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(12, 12, 6), rig.inbox() / "cube.stl");
  REQUIRE(rig.wait_for_history(1));
  const auto row = rig.history().front();
  INFO(row.dump(2));
  CHECK(row.at("state") == "done");
  CHECK(row.at("layers") == 24);
  CHECK(row.at("predicted_raw_s").get<double>() == Approx(row.at("measured_s").get<double>()).epsilon(0.03));
  const auto lines = rig.executed_print_lines();
  CHECK(std::find(lines.begin(), lines.end(), "M117 by another slicer") != lines.end());
}

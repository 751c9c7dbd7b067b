#include <catch2/catch.hpp>

#include <cmath>
#include <fstream>

#include "engine/mesh/write.h"
#include "tests/e2e/bench_rig.h"
#include "tests/support/meshes.h"

using namespace voidpath::test;
using nlohmann::json;
namespace fs = std::filesystem;
namespace mesh = voidpath::mesh;

namespace {

Result voidpath_run(std::vector<std::string> args, const ScratchDir& dir) {
  args.insert(args.begin(), program("voidpath"));
  return run(args, dir.path());
}

}  // namespace

TEST_CASE("orient --json says what the contract says") {
  const ScratchDir dir;
  mesh::write_model(comb(5, 5, 7, 20, 4), dir / "comb.stl");
  const Result r = voidpath_run({"orient", dir / "comb.stl", "--method", "thesis", "--json", "--candidates", dir / "c.csv",
                                 "--out", dir / "turned.obj"}, dir);
  INFO(r.err);
  REQUIRE(r.code == 0);
  const json j = json::parse(r.out);
  CHECK(j.at("candidates") == 1286);
  CHECK(j.at("method") == "thesis");
  CHECK(j.at("weights").at("d") == 0.11);
  CHECK(j.at("model").at("watertight") == true);
  for (const char* key : {"chosen", "as_delivered"}) {
    const json& c = j.at(key);
    for (const char* field : {"direction", "quaternion", "angles_rad", "criteria", "score", "printable", "why"}) {
      INFO(key << "." << field);
      CHECK(c.contains(field));
    }
  }
  // Standing as delivered: 24 mm tall; above the base of 4 mm, 5 posts, below it one region.
  const json& k = j.at("as_delivered").at("criteria");
  CHECK(k.at("H_mm").get<double>() == Approx(24));
  CHECK(k.at("C").get<double>() == Approx((4 * 1 + 20 * 5) / 24.0));
  // Pairs of posts k apart lie k·12 − 5 mm from each other: (4·7 + 3·19 + 2·31 + 1·43) / 10.
  CHECK(k.at("D_mm").get<double>() == Approx(19.0 * 20 / 24));
  CHECK(lines_of(read_file(dir / "c.csv")).size() == 1287);
  CHECK(lines_of(read_file(dir / "c.csv"))[0] == "dx,dy,dz,H_mm,V_mm3,C,D_mm,score,printable,predicted_s");
  CHECK(fs::file_size(dir / "turned.obj") > 100);
}

TEST_CASE("slice and estimate agree, and --direction is what points up") {
  const ScratchDir dir;
  mesh::write_model(box(30, 20, 8), dir / "b.stl");
  const Result r = voidpath_run({"slice", dir / "b.stl", "-o", dir / "b.gcode", "--direction", "1,0,0", "--json"}, dir);
  INFO(r.err);
  REQUIRE(r.code == 0);
  const json j = json::parse(r.out);
  CHECK(j.at("layers") == 150);
  CHECK(j.at("filament_mm").get<double>() > 0);
  const Result e = voidpath_run({"estimate", dir / "b.gcode", "--json"}, dir);
  REQUIRE(e.code == 0);
  const json t = json::parse(e.out);
  CHECK(t.at("predicted_s").get<double>() == Approx(j.at("predicted_s").get<double>()).epsilon(1e-9));
  CHECK(t.at("filament_mm") == j.at("filament_mm"));
  CHECK(t.at("layers") == 150);
  CHECK(t.at("by_feature").contains("External perimeter"));
}

TEST_CASE("for a MakerBot a file for its card is written") {
  const ScratchDir dir;
  mesh::write_model(box(30, 20, 8), dir / "b.stl");
  const auto slice = [&](const std::string& profile) {
    return voidpath_run({"slice", dir / "b.stl", "-o", dir / "b.x3g", "--as-delivered", "--profile", profile}, dir);
  };
  CHECK(slice("generic-marlin").code == 2);
  CHECK_FALSE(fs::exists(dir / "b.x3g"));
  const Result r = slice("makerbot-replicator-2");
  INFO(r.err);
  REQUIRE(r.code == 0);
  const std::string bytes = read_file(dir / "b.x3g");
  // 153: the build's start and name; 154: its end. In between some hundred moves of 32 bytes.
  CHECK(bytes.substr(0, 7) == std::string("\x99\0\0\0\0b\0", 7));
  CHECK(bytes.substr(bytes.size() - 2) == std::string("\x9A\0", 2));
  CHECK(bytes.size() > 32 * 500);
  CHECK_FALSE(fs::exists(dir / "b.x3g.gcode"));
  CHECK_FALSE(fs::exists(dir / "b.x3g.part"));
}

TEST_CASE("the same input gives the same G-code on one thread and on many") {
  const ScratchDir dir;
  mesh::write_model(table(40, 30, 25, 4, 6), dir / "t.stl");
  for (const std::string n : {"1", "4"})
    REQUIRE(voidpath_run({"slice", dir / "t.stl", "-o", dir / (n + ".gcode"), "--threads", n, "--as-delivered"}, dir).code == 0);
  CHECK(read_file(dir / "1.gcode") == read_file(dir / "4.gcode"));
}

TEST_CASE("exit codes are the contract's") {
  const ScratchDir dir;
  mesh::write_model(box(30, 20, 8), dir / "b.stl");
  mesh::write_model(box(600, 20, 8), dir / "big.stl");
  std::ofstream(dir / "not.stl") << "<html></html>";
  std::ofstream(dir / "bad.yaml") << "state_dirr: x\n";
  const auto code = [&](std::vector<std::string> args) { return voidpath_run(std::move(args), dir).code; };
  CHECK(code({"check", dir / "b.stl"}) == 0);
  CHECK(code({"check", dir / "not.stl"}) == 3);
  CHECK(code({"slice", dir / "big.stl", "-o", dir / "o.gcode"}) == 3);
  CHECK_FALSE(fs::exists(dir / "o.gcode"));
  CHECK(code({"slice", dir / "b.stl"}) == 2);
  CHECK(code({"slice", dir / "b.stl", "-o", dir / "o.gcode", "--set", "slice.perimetres=3"}) == 2);
  CHECK(code({"orient", dir / "b.stl", "--method", "guess"}) == 2);
  CHECK(code({"frobnicate"}) == 2);
  CHECK(code({"check", dir / "b.stl", "--config", dir / "bad.yaml"}) == 2);
  CHECK(code({"slice", dir / "b.stl", "-o", dir / "no/such/folder/o.gcode"}) == 1);
  std::ofstream(dir / "v.yaml") << "web: {listen: \"127.0.0.1:1\"}\n";
  CHECK(code({"status", "--config", dir / "v.yaml"}) == 4);
  CHECK(run({program("voidpathd"), "--check", "--config", dir / "bad.yaml"}, dir.path()).code == 2);
}

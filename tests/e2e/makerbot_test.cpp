#include "engine/mesh/write.h"
#include "tests/e2e/bench_rig.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <fstream>

#include <catch2/catch.hpp>

using namespace voidpath::test;
namespace mesh = voidpath::mesh;

namespace {

BenchRig::Options replicator() {
  BenchRig::Options o;
  o.profile = "makerbot-replicator-2";
  o.mock_args = {"--firmware", "s3g", "--baud", "115200", "--latency-ms", "1"};
  return o;
}

std::size_t count(const std::vector<std::string>& lines, const std::string& beginning) {
  return static_cast<std::size_t>(std::count_if(
      lines.begin(), lines.end(), [&](const std::string& l) { return l.starts_with(beginning); }));
}

}  // namespace

TEST_CASE("a model dropped for a MakerBot is sliced, sent as S3G, timed and logged") {
  BenchRig rig(replicator());
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(30, 20, 2), rig.inbox() / "tile.stl");
  REQUIRE(rig.wait_for_history(1, 180));
  const auto row = rig.history().at(0);
  INFO(row.dump(2));
  REQUIRE(row.at("state") == "done");
  CHECK(row.at("firmware").get<std::string>() == "Sailfish 7.7");
  const double predicted = row.at("predicted_raw_s");
  const double measured = row.at("measured_s");
  REQUIRE(measured > 60);
  CHECK(predicted == Approx(measured).epsilon(0.03));
  CHECK(row.at("heating_s").get<double>() > 20);

  const auto executed = rig.executed_lines();
  CHECK(count(executed, "M136") == 1);
  CHECK(count(executed, "M137") == 1);
  CHECK(count(executed, "G162 X Y") == 2);
  CHECK(count(executed, "G1 ") > 100);
  CHECK(executed.back() == "M137");
  const auto counts = rig.mock_counts();
  CHECK(counts.at("unknown") == 0);  // nothing such a machine may not be sent
  CHECK(counts.at("resends") == 0);
  CHECK(counts.at("hotend_target") == 0);
  CHECK(rig.stop_daemon() == 0);
}

TEST_CASE("a cancel at the MakerBot's panel cancels the job") {
  BenchRig::Options o = replicator();
  o.faults = "faults:\n  - {kind: cancel, line: 600}\n";
  BenchRig rig(o);
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(30, 20, 4), rig.inbox() / "tile.stl");
  REQUIRE(rig.wait_for_history(1, 180));
  const auto row = rig.history().at(0);
  INFO(row.dump(2));
  CHECK(row.at("state") == "cancelled");
}

TEST_CASE("G-code that a MakerBot cannot carry out to its end does not begin") {
  BenchRig rig(replicator());
  rig.start_mock();
  rig.start_daemon();
  std::ofstream(rig.inbox() / "part.gcode") << "M136\nM104 S200\nG28\nG1 X1 Y1 Z1 F1200\nG5 X2 Y2\nM137\n";
  REQUIRE(rig.wait_for_history(1));
  const auto row = rig.history().at(0);
  CHECK(row.at("state") == "failed");
  CHECK_THAT(row.at("reason").get<std::string>(), Catch::Contains("part.gcode: line 5: G5 X2 Y2: "));
  CHECK(rig.executed_lines().empty());
}

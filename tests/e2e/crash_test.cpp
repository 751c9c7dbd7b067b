#include <catch2/catch.hpp>

#include <algorithm>

#include <signal.h>

#include "engine/mesh/write.h"
#include "tests/e2e/bench_rig.h"
#include "tests/support/meshes.h"

using namespace voidpath::test;
namespace fs = std::filesystem;
namespace mesh = voidpath::mesh;

TEST_CASE("killed in the middle of a print, the job is interrupted, waits for the user and is not repeated") {
  BenchRig rig({.auto_clear = true, .mock_speed = "20"});
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(40, 40, 20), rig.inbox() / "a.stl");
  mesh::write_model(box(12, 10, 2), rig.inbox() / "b.stl");
  REQUIRE(eventually([&] { return rig.executed_print_lines().size() > 200; }));
  rig.kill_daemon();
  // The printer runs dry of what it had been given.
  double since = seconds_now();
  std::size_t seen = 0;
  REQUIRE(eventually([&] {
    if (const std::size_t now = rig.executed_lines().size(); now != seen) {
      seen = now;
      since = seconds_now();
    }
    return seconds_now() - since > 3;
  }));
  const std::size_t executed = rig.executed_print_lines().size();

  rig.start_daemon();
  REQUIRE(eventually([&] { return rig.cli({"queue"}).out.find("interrupted") != std::string::npos; }));
  // The bed is not known to be clear: neither the interrupted part nor the next one starts.
  REQUIRE(eventually([&] { return rig.cli({"queue"}).out.find("waiting") != std::string::npos; }));
  const auto after = rig.executed_print_lines();
  for (std::size_t i = executed; i < after.size(); ++i) CHECK_THAT(after[i], !Catch::StartsWith("G1"));

  std::string id;
  const auto queue = rig.cli_json({"queue", "--json"});
  for (const auto& job : queue.at("jobs"))
    if (job.at("state") == "interrupted") id = job.at("id").dump();
  REQUIRE_FALSE(id.empty());
  REQUIRE(rig.cli({"discard", id}).code == 0);
  REQUIRE(rig.cli({"bed-clear"}).code == 0);
  REQUIRE(eventually([&] { return fs::exists(rig.inbox() / "done" / "b.stl"); }));
  CHECK_FALSE(fs::exists(rig.inbox() / "done" / "a.stl"));
}

TEST_CASE("killed while preparing, the job is prepared again and printed once") {
  BenchRig rig;
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(sphere(14, 60, 120), rig.inbox() / "ball.stl");
  REQUIRE(eventually([&] { return rig.cli({"queue"}).out.find("preparing") != std::string::npos; }));
  rig.kill_daemon();
  rig.start_daemon();
  REQUIRE(rig.wait_for_history(1));
  REQUIRE(rig.history().size() == 1);
  CHECK(rig.history()[0].at("state") == "done");
    const auto lines = rig.executed_print_lines();
  CHECK(std::count(lines.begin(), lines.end(), "G28") == 1);
}

TEST_CASE("a cable pulled in the middle of a print fails it and the printer is found again") {
  BenchRig rig({.mock_speed = "20"});
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(40, 40, 20), rig.inbox() / "a.stl");
  REQUIRE(eventually([&] { return rig.executed_print_lines().size() > 200; }));
  rig.mock().signal(SIGKILL);
  REQUIRE(rig.wait_for_history(1));
  CHECK(rig.history()[0].at("state") == "failed");
  rig.start_mock();
  REQUIRE(rig.cli({"bed-clear"}).code == 0);
  mesh::write_model(box(12, 10, 2), rig.inbox() / "b.stl");
  REQUIRE(rig.wait_for_history(2));
  CHECK(fs::exists(rig.inbox() / "done" / "b.stl"));
}

TEST_CASE("SIGTERM in the middle of a print turns the heaters off and leaves the job interrupted") {
  BenchRig rig({.mock_speed = "20"});
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(40, 40, 20), rig.inbox() / "a.stl");
  REQUIRE(eventually([&] { return rig.executed_print_lines().size() > 200; }));
  CHECK(rig.stop_daemon() == 0);
  const auto lines = rig.executed_lines();
  CHECK(std::count(lines.begin(), lines.end(), "M104 S0") >= 1);
  CHECK(std::count(lines.begin(), lines.end(), "M140 S0") >= 1);
  rig.start_daemon();
  CHECK(rig.cli({"queue"}).out.find("interrupted") != std::string::npos);
}

#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <set>

#include <signal.h>

#include "engine/mesh/write.h"
#include "tests/e2e/bench_rig.h"
#include "tests/support/meshes.h"

using namespace voidpath::test;
namespace fs = std::filesystem;
namespace mesh = voidpath::mesh;

namespace {

/// As a slow network copy does it: part of the file, a pause, the rest.
class SlowCopy {
 public:
  SlowCopy(const fs::path& from, const fs::path& to) : bytes_(read_file(from)), out_(to, std::ios::binary) {
    out_.write(bytes_.data(), static_cast<std::streamsize>(bytes_.size() / 2));
    out_.flush();
  }
  void finish() {
    out_.write(bytes_.data() + bytes_.size() / 2, static_cast<std::streamsize>(bytes_.size() - bytes_.size() / 2));
    out_.close();
  }

 private:
  std::string bytes_;
  std::ofstream out_;
};

std::vector<std::string> names(const nlohmann::json& history) {
  std::vector<std::string> out;
  for (const auto& row : history) out.push_back(fs::path(row.at("file").get<std::string>()).filename());
  return out;
}

}  // namespace

TEST_CASE("three models dropped at once, one half-copied for a while, print in order and line for line") {
  BenchRig rig;
  rig.start_mock();
  rig.start_daemon();
  const fs::path out = rig.dir() / "made";
  fs::create_directories(out);
  mesh::write_model(comb(4, 4, 6, 10, 3), out / "comb.stl");
  mesh::write_model(cup(24, 20, 14, 2, 2), out / "cup.obj");
  mesh::write_model(table(24, 20, 12, 3, 4), out / "table.stl");

  SlowCopy slow(out / "table.stl", rig.inbox() / "table.stl");
  fs::copy_file(out / "comb.stl", rig.inbox() / "comb.stl");
  REQUIRE(eventually([&] { return rig.status().dump().find("comb.stl") != std::string::npos; }));
  fs::copy_file(out / "cup.obj", rig.inbox() / "cup.obj");
  REQUIRE(rig.wait_for_history(2));
  CHECK(fs::exists(rig.inbox() / "table.stl"));  // still being copied: nobody touched it
  slow.finish();
  REQUIRE(rig.wait_for_history(3));

  const auto history = rig.history();
  const auto order = names(history);
  REQUIRE(order.size() == 3);
  CHECK(std::set<std::string>(order.begin(), order.end()) == std::set<std::string>{"comb.stl", "cup.obj", "table.stl"});
  for (const auto& row : history) {
    INFO(row.dump(2));
    CHECK(row.at("state") == "done");
    const double predicted = row.at("predicted_raw_s");
    const double measured = row.at("measured_s");
    REQUIRE(measured > 10);
    CHECK(predicted == Approx(measured).epsilon(0.03));
    CHECK(row.at("heating_s").get<double>() > 0);
    CHECK(row.at("total_s").get<double>() >= measured);
    CHECK(row.at("model_sha256").get<std::string>().size() == 64);
    CHECK(row.at("criteria").at("H_mm").get<double>() > 0);
  }

  // What was sliced is what was executed, in the order of the history.
  std::vector<std::string> expected;
  std::vector<nlohmann::json> rows(history.begin(), history.end());
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.at("started") < b.at("started"); });
  for (const auto& row : rows) {
    const std::string name = fs::path(row.at("file").get<std::string>()).filename();
    const fs::path gcode = rig.dir() / (name + ".gcode");
    const Result r = rig.cli({"slice", (out / name).string(), "-o", gcode.string()});
    REQUIRE(r.code == 0);
    for (const std::string& line : commands_of(gcode)) expected.push_back(line);
  }
  const auto executed = rig.executed_print_lines();
  REQUIRE(executed.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    if (executed[i] != expected[i]) {
      INFO("line " << i);
      REQUIRE(executed[i] == expected[i]);
    }

  for (const std::string name : {"comb.stl", "cup.obj", "table.stl"}) {
    CHECK(fs::exists(rig.inbox() / "done" / name));
    CHECK_FALSE(fs::exists(rig.inbox() / name));
  }
  const auto counts = rig.mock_counts();
  CHECK(counts.at("resends") == 0);
  CHECK(rig.stop_daemon() == 0);
}

TEST_CASE("a printer that accelerates less than its profile says is predicted by what it says itself") {
  BenchRig rig({.mock_args = {"--acceleration", "500,1500,600"}});
  rig.start_mock();
  rig.start_daemon();
  REQUIRE(eventually([&] { return rig.status().at("printers")[0].at("limits_differ").size() == 2; }));
  const Result status = rig.cli({"status"});
  CHECK(status.out.find("print acceleration: the printer says 500 mm/s², its profile 1000") != std::string::npos);
  mesh::write_model(comb(4, 4, 6, 10, 3), rig.inbox() / "comb.stl");
  REQUIRE(rig.wait_for_history(1));
  const auto row = rig.history()[0];
  INFO(row.dump(2));
  CHECK(row.at("state") == "done");
  CHECK(row.at("limits_from") == "printer");
  CHECK(row.at("limits").get<std::string>().find("print 500,") != std::string::npos);
  CHECK(row.at("predicted_raw_s").get<double>() == Approx(row.at("measured_s").get<double>()).epsilon(0.03));
}

TEST_CASE("nothing prints before the bed is known to be clear") {
  BenchRig rig({.auto_clear = false});
  rig.start_mock();
  rig.start_daemon();
  mesh::write_model(box(15, 10, 3), rig.inbox() / "a.stl");
  REQUIRE(eventually([&] { return rig.status().dump().find("bed") != std::string::npos &&
                                  rig.cli({"queue"}).out.find("a.stl") != std::string::npos; }));
  // Prepared, and waiting: no heater, no move.
  REQUIRE(eventually([&] { return rig.cli({"queue"}).out.find("waiting") != std::string::npos; }));
  for (const std::string& line : rig.executed_print_lines()) CHECK_THAT(line, !Catch::StartsWith("G1") && !Catch::StartsWith("M1"));
  REQUIRE(rig.cli({"bed-clear"}).code == 0);
  REQUIRE(rig.wait_for_history(1));
  // The finished part lies on the bed: the next one waits again.
  const std::size_t executed = rig.executed_print_lines().size();
  mesh::write_model(box(12, 10, 3), rig.inbox() / "b.stl");
  REQUIRE(eventually([&] { return rig.cli({"queue"}).out.find("waiting") != std::string::npos; }));
  CHECK(rig.executed_print_lines().size() == executed);
}

TEST_CASE("a ready G-code file prints as it is") {
  BenchRig rig;
  rig.start_mock();
  rig.start_daemon();
  std::ofstream(rig.inbox() / "line.gcode") << "; by hand\nM109 S200\nG28\nG1 X10 Y10 F3000 ; go\n\nG1 X60 E2 F1200\nM104 S0\n";
  REQUIRE(rig.wait_for_history(1));
  CHECK(rig.history()[0].at("state") == "done");
  CHECK(rig.executed_print_lines() ==
        std::vector<std::string>{"M109 S200", "G28", "G1 X10 Y10 F3000", "G1 X60 E2 F1200", "M104 S0"});
  CHECK(rig.history()[0].at("measured_s").get<double>() == Approx(rig.history()[0].at("predicted_raw_s").get<double>()).epsilon(0.03));
}

TEST_CASE("a hopeless file ends in failed/ with a report, and the queue goes on") {
  BenchRig rig;
  rig.start_mock();
  rig.start_daemon();
  std::ofstream(rig.inbox() / "page.stl") << "<html>not a model</html>";
  mesh::write_model(box(15, 10, 3), rig.inbox() / "good.stl");
  REQUIRE(rig.wait_for_history(2));
  CHECK(fs::exists(rig.inbox() / "failed" / "page.stl"));
  CHECK(fs::exists(rig.inbox() / "done" / "good.stl"));
  bool told = false;
  for (const auto& entry : fs::directory_iterator(rig.inbox() / "failed"))
    told = told || (entry.path().filename() != "page.stl" &&
                    read_file(entry.path()).find("page.stl") != std::string::npos);
  CHECK(told);
}

TEST_CASE("cancel ends safely: heaters off, the job is cancelled, the next one can print") {
  BenchRig rig({.auto_clear = false, .mock_speed = "20"});
  rig.start_mock();
  rig.start_daemon();
  REQUIRE(rig.cli({"bed-clear"}).code == 0);
  mesh::write_model(box(40, 40, 20), rig.inbox() / "a.stl");
  REQUIRE(eventually([&] { return rig.executed_print_lines().size() > 100; }));
  REQUIRE(rig.cli({"cancel"}).code == 0);
  REQUIRE(rig.wait_for_history(1));
  CHECK(rig.history()[0].at("state") == "cancelled");
  REQUIRE(eventually([&] {
    const auto lines = rig.executed_lines();
    return std::count(lines.begin(), lines.end(), "M104 S0") >= 1 && std::count(lines.begin(), lines.end(), "M140 S0") >= 1;
  }));
  CHECK(rig.cli({"queue"}).out.find("printing") == std::string::npos);
}

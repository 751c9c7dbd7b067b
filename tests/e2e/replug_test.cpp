#include "tests/e2e/bench_rig.h"

#include <algorithm>
#include <fstream>

#include <catch2/catch.hpp>
#include <signal.h>

using namespace voidpath::test;
namespace fs = std::filesystem;

namespace {

/// The stable name of a port, as udev gives it: a link to whatever the device is called this time.
class ById {
 public:
  explicit ById(const fs::path& dir) : link_(dir / "by-id" / kName) { fs::create_directories(dir / "by-id"); }
  void plug(const std::string& device) { fs::create_symlink("../" + device, link_); }
  void pull() { fs::remove(link_); }
  static std::string port() { return std::string("by-id/") + kName; }

 private:
  static constexpr const char* kName = "usb-voidpath_mock_0001-if00-port0";
  fs::path link_;
};

/// Hot from its beginning, a minute of moves.
void drop_slow_print(const fs::path& file) {
  std::ofstream out(file);
  out << "M104 S60\nG28\n";
  for (int i = 0; i < 60; ++i) out << "G1 X" << (i % 2 == 0 ? 60 : 50) << " F600\n";
}

bool offline(BenchRig& rig) { return !rig.status().at("printers")[0].at("connected").get<bool>(); }

std::size_t count(const std::vector<std::string>& lines, const std::string& what) {
  return static_cast<std::size_t>(std::count(lines.begin(), lines.end(), what));
}

}  // namespace

TEST_CASE(
    "a printer pulled in mid-print comes back as another device, is made cold and prints the next part") {
  BenchRig rig({.mock_speed = "1", .port = ById::port()});
  ById by_id(rig.dir());
  rig.start_mock("ttyUSB0");
  by_id.plug("ttyUSB0");
  rig.start_daemon();
  drop_slow_print(rig.inbox() / "slow.gcode");
  REQUIRE(eventually([&] { return count(rig.executed_print_lines(), "G1 X50 F600") > 0; }));

  by_id.pull();
  rig.mock().signal(SIGKILL);
  REQUIRE(rig.wait_for_history(1));
  CHECK(rig.history()[0].at("state") == "failed");
  CHECK_THAT(rig.history()[0].at("reason").get<std::string>(), Catch::Contains("connection lost"));
  REQUIRE(eventually([&] { return offline(rig); }));

  rig.start_mock("ttyUSB1");
  by_id.plug("ttyUSB1");
  REQUIRE(eventually([&] { return !offline(rig); }));
  REQUIRE(eventually([&] { return count(rig.executed_lines(), "M140 S0") == 1; }));
  CHECK(count(rig.executed_lines(), "M104 S0") == 1);
  // Nothing goes on by itself: what lies on the bed is in the way.
  std::ofstream(rig.inbox() / "next.gcode") << "G28\nG1 X10 F6000\n";
  REQUIRE(eventually([&] { return rig.cli({"queue"}).out.find("waiting") != std::string::npos; }));
  CHECK(count(rig.executed_lines(), "G28") == 0);
  REQUIRE(rig.cli({"bed-clear"}).code == 0);
  REQUIRE(rig.wait_for_history(2));
  CHECK(fs::exists(rig.inbox() / "done" / "next.gcode"));
  CHECK(count(rig.executed_lines(), "G28") == 1);
}

TEST_CASE("a cable pulled for a while from a printer that lives on leaves it cold, and the print ended") {
  BenchRig rig({.mock_speed = "1",
                .faults = "faults:\n  - {kind: unplug, line: 20, seconds: 2}\n",
                .port = ById::port()});
  ById by_id(rig.dir());
  rig.start_mock("ttyACM0");
  by_id.plug("ttyACM0");
  rig.start_daemon();
  drop_slow_print(rig.inbox() / "slow.gcode");
  REQUIRE(rig.wait_for_history(1));
  CHECK(rig.history()[0].at("state") == "failed");
  REQUIRE(eventually([&] { return !offline(rig); }));
  REQUIRE(eventually([&] { return rig.mock_counts().at("hotend_target") == 0; }));
  const auto printed =
      count(rig.executed_print_lines(), "G1 X50 F600") + count(rig.executed_print_lines(), "G1 X60 F600");
  CHECK(printed < 30);
  CHECK(rig.cli({"queue"}).out.find("printing") == std::string::npos);
}

TEST_CASE("signs that a damaged line was obeyed are told where people look") {
  BenchRig rig({.mock_speed = "1"});
  rig.start_mock();
  rig.start_daemon();
  // 300 mm of filament in one move is beyond reason: the firmware leaves it out.
  std::ofstream(rig.inbox() / "odd.gcode")
      << "M302 S0\nG28\nG92 E0\nG1 X10 E300 F6000\nG4 S11\nG1 X20 F600\n";
  const std::string told = "signs that a damaged line was obeyed: 1";
  CHECK(eventually([&] { return rig.cli({"status"}).out.find("link: " + told) != std::string::npos; }));
  REQUIRE(rig.wait_for_history(1));
  CHECK(rig.history()[0].at("doubts") == 1);
  CHECK_THAT(rig.cli({"history"}).out, Catch::Contains(told));
}

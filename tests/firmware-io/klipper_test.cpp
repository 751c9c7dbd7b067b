// Klipper's pseudo terminal: no boot to be heard, no numbers checked, `!!` for what it will not do.
#include "tests/firmware-io/mock_bench.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

mock::OptionsBuilder klipper() { return mock::make_mock().firmware("klipper"); }

std::vector<std::string> moves(int n) {
  std::vector<std::string> file = {"G28"};
  for (int i = 1; i <= n; ++i) file.push_back("G1 X" + std::to_string(i) + " E" + std::to_string(i));
  return file;
}

std::uint64_t doubts(const MockBench& bench) {
  return bench.find<LinkStats>(bench.count<LinkStats>() - 1)->doubts;
}

}  // namespace

TEST_CASE("Klipper says who it is behind its ok, and is asked nothing it does not know", "[klipper]") {
  MockBench bench(klipper().build());
  REQUIRE(bench.connect());
  CHECK(bench.find<Connected>()->firmware.name == "Klipper");
  bench.run_for(10);
  CHECK(bench.printer.statistics().unknown == 0);
  REQUIRE(bench.count<Temperatures>() > 0);
  const auto& sensors = bench.find<Temperatures>()->sensors;
  CHECK(sensors.count("T0") == 1);
  CHECK(sensors.count("B") == 1);
}

TEST_CASE("a print on Klipper waits out a heating longer than any patience, and ends", "[klipper]") {
  mock::Options options = klipper().instant_moves().build();
  // 2.2 K a minute: just what the guard over it lets pass, and 16 minutes to 60 °C.
  options.bed = {.ambient = 25, .full_power = 1000, .time_constant = 26600, .maximum = 120};
  MockBench bench(options);
  REQUIRE(bench.connect());
  std::vector<std::string> file = moves(20);
  file.insert(file.begin() + 1, {"M201 X500", "M190 S60", "M109 S200"});
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 5000));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printer.statistics().heating_s > 900);
  CHECK(bench.count<Paused>() == 0);
  // M201 is unknown there, and was meant.
  CHECK(bench.printer.statistics().unknown == 1);
  CHECK(doubts(bench) == 0);
}

TEST_CASE("a word that stands for many commands is waited for, whatever it says meanwhile", "[klipper]") {
  mock::Options options = klipper().instant_moves().cold_extrusion().build();
  options.bed = {.ambient = 25, .full_power = 1000, .time_constant = 26600, .maximum = 120};  // 16 minutes
  options.leveling_s = 1200;
  MockBench bench(options);
  REQUIRE(bench.connect());
  const std::string word = GENERATE("START_PRINT BED=60", "BED_MESH_CALIBRATE", "QUAD_GANTRY_LEVEL");
  CAPTURE(word);
  std::vector<std::string> file = moves(40);
  if (word.starts_with("START"))
    file.front() = word;  // which homes
  else
    file.insert(file.begin() + 30, word);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 5000));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK_FALSE(bench.printer.halted());
  CHECK(bench.printer.statistics().unknown == 0);
}

TEST_CASE("the first motion behind a word that stands for many commands is timed when it can begin",
          "[klipper]") {
  MockBench bench(klipper().instant_moves().cold_extrusion().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = moves(40);
  file.front() = "START_PRINT BED=60";
  double ended = 0;
  bench.on_input = [&](const std::string&) {
    if (ended == 0 && bench.log.back().starts_with("G1")) ended = bench.t();
  };
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 500));
  REQUIRE(bench.count<MotionStarted>() == 1);
  for (const Event& event : bench.events)
    if (std::holds_alternative<MotionStarted>(event.what)) CHECK(event.at_s > ended - 1);
}

TEST_CASE("what Klipper will not do pauses the print with its reason", "[klipper]") {
  MockBench bench(klipper().instant_moves().build());
  REQUIRE(bench.connect());
  const bool cold = GENERATE(false, true);
  std::vector<std::string> file = moves(200);
  if (!cold) file.erase(file.begin());
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  CHECK(bench.find<Paused>()->by_printer);
  const std::string reason = bench.find<Paused>()->reason;
  if (cold)
    CHECK(reason == "Extrude below minimum temp");
  else
    CHECK_THAT(reason, Catch::StartsWith("Must home axis first"));
  bench.run_for(10);
  CHECK_FALSE(bench.over());
  CHECK(bench.log.size() < 100);
  bench.driver.cancel("", bench.t());
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintCancelled>() == 1);
}

namespace {

/// A print that stands paused by a word in its file.
struct PausedKlipper {
  MockBench bench{klipper().instant_moves().cold_extrusion().build()};
  std::vector<std::string> file = moves(40);
  PausedKlipper() {
    REQUIRE(bench.connect());
    file.insert(file.begin() + 20, "PAUSE");
    bench.print(file);
    REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
    bench.run_for(10);  // it answers meanwhile
    CHECK(bench.count<Paused>() == 1);
  }
  std::ptrdiff_t said(const std::string& line) const {
    return std::count(bench.log.begin(), bench.log.end(), line);
  }
  /// Of the file behind its pause.
  bool goes_on() const { return said(file[21]) > 0; }
};

}  // namespace

TEST_CASE("a Klipper that has parked is told to go back before the print goes on", "[klipper]") {
  PausedKlipper rig;
  CHECK_FALSE(rig.goes_on());
  SECTION("by the user here") {
    rig.bench.driver.resume(rig.bench.t());
    CHECK(rig.bench.count<Resumed>() == 0);
    REQUIRE(rig.bench.run_until([&] { return rig.bench.over(); }));
    CHECK(rig.said("RESUME") == 1);
    rig.file.insert(rig.file.begin() + 21, "RESUME");
  }
  SECTION("by its own page") {
    rig.bench.driver.command("RESUME", rig.bench.t());
    REQUIRE(rig.bench.run_until([&] { return rig.bench.over(); }));
    rig.file.insert(rig.file.begin() + 21, "RESUME");
  }
  SECTION("which forgot about it meanwhile") {
    rig.bench.driver.command("CLEAR_PAUSE", rig.bench.t());
    rig.bench.run_for(1);
    rig.bench.driver.resume(rig.bench.t());
    REQUIRE(rig.bench.run_until([&] { return rig.bench.over(); }));
    rig.file.insert(rig.file.begin() + 21, {"CLEAR_PAUSE", "RESUME"});
  }
  CHECK(rig.bench.count<PrintFinished>() == 1);
  CHECK(rig.bench.count<Resumed>() == 1);
  std::erase(rig.bench.log, "M105");
  CHECK(std::search(rig.bench.log.begin(), rig.bench.log.end(), rig.file.begin(), rig.file.end()) !=
        rig.bench.log.end());
}

TEST_CASE("a Klipper that will not go back stays paused, and can be told again", "[klipper]") {
  PausedKlipper rig;
  bool refuses = true;
  rig.bench.to_host = [&](std::string text) {
    const std::string resumed = "// action:resumed\n";
    if (const auto at = text.find(resumed); refuses && at != text.npos)
      text.replace(at, resumed.size(), "!! Extrude below minimum temp\n");
    return text;
  };
  rig.bench.driver.resume(rig.bench.t());
  rig.bench.run_for(10);
  CHECK(rig.said("RESUME") == 1);
  CHECK(rig.bench.count<Resumed>() == 0);
  CHECK_FALSE(rig.goes_on());
  refuses = false;
  rig.bench.driver.resume(rig.bench.t());
  REQUIRE(rig.bench.run_until([&] { return rig.bench.over(); }));
  CHECK(rig.said("RESUME") == 2);
  CHECK(rig.bench.count<PrintFinished>() == 1);
}

TEST_CASE("a Klipper whose paused print is cancelled can pause the next one", "[klipper]") {
  PausedKlipper rig;
  rig.bench.driver.cancel("", rig.bench.t());
  REQUIRE(rig.bench.run_until([&] { return rig.bench.over(); }));
  CHECK(rig.bench.count<PrintCancelled>() == 1);
  CHECK(rig.said("TURN_OFF_HEATERS") == 1);
  CHECK(rig.bench.printer.statistics().unknown == 0);
  rig.bench.print(rig.file);
  REQUIRE(rig.bench.run_until([&] { return rig.bench.count<Paused>() == 2; }));
}

TEST_CASE("an emergency stop reaches Klipper ahead of what is queued; restarted, it prints again",
          "[klipper]") {
  MockBench bench(klipper().cold_extrusion().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = {"G28"};
  for (int i = 0; i < 400; ++i) file.push_back("G1 X" + std::to_string(i % 2 == 0 ? 60 : 0) + " F3000");
  bench.print(file);
  bench.run_for(8);
  REQUIRE(bench.count<LineDone>() > 5);
  bench.driver.halt("button", bench.t());
  bench.printer.feed(std::exchange(bench.driver.output(), {}));
  CHECK(bench.printer.halted());
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 30));
  bench.printer.feed("FIRMWARE_RESTART\n");
  REQUIRE(bench.run_until([&] { return bench.count<Connected>() == 2; }));
  bench.run_for(1);
  const int finished = bench.count<PrintFinished>();
  bench.print({"G28", "G1 X10 F600"});
  REQUIRE(bench.run_until([&] { return bench.count<PrintFinished>() > finished; }));
}

TEST_CASE("a Klipper that is shut down fails the print in its words", "[klipper]") {
  mock::Options options = klipper().instant_moves().cold_extrusion().build();
  mock::Fault halt;
  halt.kind = mock::FaultKind::kHalt;
  halt.trigger = mock::FaultTrigger::kLine;
  halt.at = 50;
  halt.text = "Heater extruder not heating at expected rate";
  options.faults = {halt};
  MockBench bench(options);
  REQUIRE(bench.connect());
  bench.print(moves(200));
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  REQUIRE(bench.count<PrintFailed>() == 1);
  CHECK_THAT(bench.find<PrintFailed>()->reason, Catch::Contains("not heating at expected rate"));
}

TEST_CASE("a wait for a person that the firmware does not know is a pause of the print", "[klipper]") {
  const std::string firmware = GENERATE("klipper", "marlin2", "repetier");
  CAPTURE(firmware);
  MockBench bench(mock::make_mock().firmware(firmware).instant_moves().cold_extrusion().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = moves(20);
  file.insert(file.begin() + 10, firmware == "klipper" ? "M600" : "M226 P1");
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  CHECK(bench.find<Paused>()->reason.find("nknown command") != std::string::npos);
  bench.run_for(60);
  CHECK_FALSE(bench.over());
  CHECK(std::count(bench.log.begin(), bench.log.end(), file[11]) == 0);
  bench.driver.resume(bench.t());
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("reports that the firmware does not know are not relied upon", "[klipper]") {
  MockBench bench(klipper().cold_extrusion().build());
  REQUIRE(bench.connect());
  bench.driver.command("M155 S2", bench.t());
  bench.run_for(5);
  std::vector<std::string> file = {"G28"};
  for (int i = 0; i < 400; ++i) file.push_back("G1 X" + std::to_string(i % 2 * 60) + " F3000");
  bench.print(file);
  bench.run_for(60);
  const int told = bench.count<Temperatures>();
  bench.run_for(60);
  REQUIRE_FALSE(bench.over());
  CHECK(bench.count<Temperatures>() - told >= 5);
}

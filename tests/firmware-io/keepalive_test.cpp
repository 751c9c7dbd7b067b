#include "tests/firmware-io/mock_bench.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

std::vector<std::string> keepalives(const MockBench& bench) {
  std::vector<std::string> out = bench.log;
  std::erase_if(out, [](const std::string& line) { return !line.starts_with("M113"); });
  return out;
}

}  // namespace

TEST_CASE("a Marlin is told how often to say that it is busy, others are not", "[keepalive]") {
  const std::string firmware = GENERATE("marlin2", "marlin1", "prusa", "repetier", "smoothie");
  const int interval = GENERATE(0, 5);
  CAPTURE(firmware, interval);
  marlin::DriverOptions options;
  options.keepalive_s = interval;
  MockBench bench(mock::make_mock().firmware(firmware).build(), options);
  REQUIRE(bench.connect());
  bench.run_for(5);
  const bool marlin = firmware != "repetier" && firmware != "smoothie";
  const std::vector<std::string> wanted =
      marlin && interval > 0 ? std::vector<std::string>{"M113 S5"} : std::vector<std::string>{};
  CHECK(keepalives(bench) == wanted);
}

namespace {

/// Shows its boot screen so long behind its banner, and reads nothing meanwhile.
mock::Options slow_to_boot(double seconds) {
  mock::Fault screen;
  screen.kind = mock::FaultKind::kSilence;
  screen.trigger = mock::FaultTrigger::kTime;
  screen.at = 0;
  screen.seconds = seconds;
  return mock::make_mock()
      .baud(115200)
      .round_trip(0.002)
      .instant_moves()
      .cold_extrusion()
      .fault(screen)
      .build();
}

}  // namespace

TEST_CASE("a printer that sits in its boot screen for long is connected to when it is through",
          "[keepalive]") {
  MockBench bench(slow_to_boot(GENERATE(1.0, 5.0, 15.0, 30.0)));
  REQUIRE(bench.connect());
  CHECK(bench.count<Disconnected>() == 0);
  CHECK(bench.printer.statistics().bytes_dropped == 0);
}

TEST_CASE("a boot screen does not make the wire seem slow", "[keepalive]") {
  const auto seconds = [](bool damaged) {
    mock::Options options = slow_to_boot(1.3);
    mock::Fault garble;
    garble.kind = mock::FaultKind::kGarbleLine;
    garble.at = 60;
    if (damaged) options.faults.push_back(garble);
    MockBench bench(options);
    REQUIRE(bench.connect());
    bench.run_for(2);
    const double begun = bench.t();
    std::vector<std::string> file;
    for (int i = 0; i < 200; ++i) file.push_back("G1 X" + std::to_string(i) + " Y3.217 E0.00123");
    bench.print(file);
    REQUIRE(bench.run_until([&] { return bench.over(); }));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK((bench.printer.statistics().resends > 0) == damaged);
    return bench.t() - begun;
  };
  CHECK(seconds(true) - seconds(false) < 0.25);
}

TEST_CASE("a firmware without M113 says so to nobody and prints as before", "[keepalive]") {
  mock::Options options = mock::make_mock().instant_moves().build();
  options.dialect.busy = false;
  MockBench bench(options);
  REQUIRE(bench.connect());
  bench.run_for(5);
  CHECK(keepalives(bench).size() == 1);
  for (const Event& event : bench.events)
    if (const auto* message = std::get_if<Message>(&event.what))
      CHECK(message->text.find("Unknown") == std::string::npos);
  CHECK(bench.count<LimitsKnown>() == 1);
  bench.print({"G1 X10 F600", "G1 X20"});
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("a printer that may be silent for a minute is not given up before", "[keepalive]") {
  // Longer than what ends a print of a firmware that speaks every two seconds.
  marlin::DriverOptions options;
  options.keepalive_s = 60;
  mock::Options firmware = mock::make_mock().instant_moves().build();
  firmware.leveling_s = 200;
  MockBench bench(firmware, options);
  REQUIRE(bench.connect());
  bench.print({"G28", "G29", "G1 X10 F600"});
  REQUIRE(bench.run_until([&] { return bench.over(); }, 600));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("a printer set to be mute while it works is made to speak, so that its death is soon known",
          "[keepalive]") {
  mock::Options firmware = mock::make_mock().instant_moves().build();
  firmware.busy_interval_s = 0;  // M113 S0
  firmware.leveling_s = 100;
  mock::Fault death;
  death.kind = mock::FaultKind::kSilence;
  death.trigger = mock::FaultTrigger::kTime;
  death.at = 60;
  death.seconds = 1e6;
  firmware.faults = {death};
  MockBench bench(firmware);
  REQUIRE(bench.connect());
  bench.print({"G28", "G29", "G1 X10 F600"});
  REQUIRE(bench.run_until([&] { return bench.over(); }, 2000));
  CHECK(bench.count<PrintFailed>() == 1);
  CHECK(bench.printer.now() < 120);
}

TEST_CASE("however seldom a printer says that it is busy, it is not given up at its work", "[keepalive]") {
  marlin::DriverOptions options;
  options.keepalive_s = 0;
  mock::Options firmware = mock::make_mock().build();
  firmware.busy_interval_s = 10;
  firmware.leveling_s = 600;
  const std::string work = GENERATE("G29", "G1 X1000 F300");
  CAPTURE(work);
  MockBench bench(firmware, options);
  REQUIRE(bench.connect());
  std::vector<std::string> file(20, "G1 X0");  // enough oks behind the homing
  file.insert(file.begin(), "G28");
  file.insert(file.end(), {work, "G1 X0", "G1 X1"});
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 1000));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("how often the printer says that it is busy is not for a file to set", "[keepalive]") {
  mock::Options firmware = mock::make_mock().firmware("marlin1").instant_moves().build();
  firmware.leveling_s = 600;
  const std::string line = GENERATE("M113 S0", "M113 S60");
  MockBench bench(firmware);
  REQUIRE(bench.connect());
  bench.print({"G28", "G4 P5000", line, "G29", "G1 X10 F600"});
  REQUIRE(bench.run_until([&] { return bench.over(); }, 1000));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(std::count(bench.log.begin(), bench.log.end(), line) == 0);
}

TEST_CASE("whether the printer says its temperatures is not for a file to set, and known where a person does",
          "[keepalive]") {
  MockBench bench(mock::make_mock().cold_extrusion().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = {"M155 S0"};
  for (int i = 0; i < 200; ++i) file.push_back("G1 X" + std::to_string(i % 2 * 60) + " F3000");
  int wanted = 50;
  SECTION("a file") {}
  SECTION("a person") {
    wanted = 5;  // asked for, as often as of any cold printer
    bench.driver.command("M155 S0", bench.t());
    bench.run_for(5);
  }
  const int told = bench.count<Temperatures>();
  bench.print(file);
  bench.run_for(60);
  REQUIRE_FALSE(bench.over());
  CHECK(bench.count<Temperatures>() - told >= wanted);
}

TEST_CASE("a printer that a person has made mute is not given up at its work", "[keepalive]") {
  mock::Options firmware = mock::make_mock().firmware("marlin1").instant_moves().build();
  firmware.leveling_s = 600;
  MockBench bench(firmware);
  REQUIRE(bench.connect());
  bench.driver.command("G4 P5000", bench.t());
  bench.run_for(10);
  bench.driver.command("M113 S0", bench.t());
  bench.driver.command("G29", bench.t());
  bench.run_for(700);
  CHECK(bench.count<Disconnected>() == 0);
}

TEST_CASE("a tuning that tells nothing but temperatures is waited for", "[keepalive]") {
  const std::string firmware = GENERATE("marlin2", "marlin1", "prusa");
  const bool printed = GENERATE(false, true);
  CAPTURE(firmware, printed);
  MockBench bench(mock::make_mock().firmware(firmware).instant_moves().build());
  REQUIRE(bench.connect());
  bench.driver.command("G4 P5000", bench.t());  // it is known to say that it is busy
  bench.run_for(10);
  if (printed)
    bench.print({"M303 E0 C8 S200", "G1 X10 F600"});
  else
    bench.driver.command("M303 E0 C8 S200", bench.t());
  bench.run_for(700);
  CHECK(bench.count<Disconnected>() == 0);
  CHECK(bench.over() == printed);
  CHECK(bench.count<PrintFailed>() == 0);
}

TEST_CASE(
    "a levelling run whose ok was lost, and the answer to the question behind it, is soon known to be over",
    "[keepalive]") {
  mock::Options firmware = mock::make_mock().instant_moves().build();
  MockBench bench(firmware);
  REQUIRE(bench.connect());
  int lost = 0;
  bench.to_host = [&](std::string text) {
    const bool levelled = std::find(bench.log.begin(), bench.log.end(), "G29") != bench.log.end();
    const auto ok = text.find("ok");
    if (levelled && ok != text.npos && lost < 2) text[ok] = 'g', ++lost;
    return text;
  };
  bench.print({"G28", "G29", "G1 X10 F600"});
  REQUIRE(bench.run_until([&] { return bench.over(); }, 120));
  CHECK(lost == 2);
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printer.now() < 60);
}

TEST_CASE("what a firmware does not know is a sign of damage only where it was not sent", "[keepalive]") {
  const bool damaged = GENERATE(false, true);
  CAPTURE(damaged);
  MockBench bench(mock::make_mock().cold_extrusion().instant_moves().build());
  REQUIRE(bench.connect());
  bool said = false;
  bench.to_host = [&](std::string text) {
    if (damaged && bench.count<LineDone>() > 10 && !std::exchange(said, true))
      text = "echo:Unknown command: \"M862.3 Q\"\n" + text;
    return text;
  };
  std::vector<std::string> file = {"M862.3 P\"MK3S\"", "M572 S0.02"};
  for (int i = 0; i < 40; ++i) file.push_back("G1 X" + std::to_string(i) + " E" + std::to_string(i));
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printer.statistics().unknown == 2);
  CHECK(said == damaged);
  CHECK(bench.find<LinkStats>(bench.count<LinkStats>() - 1)->doubts == (damaged ? 1 : 0));
}

TEST_CASE("what a user types gets through a print full of short waits", "[keepalive]") {
  MockBench bench(mock::make_mock().firmware("marlin1").cold_extrusion().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file;
  for (int i = 0; i < 400; ++i)
    file.push_back(i % 4 == 0 ? "G4 P1" : "G1 X" + std::to_string(i % 2 * 60) + " F3000");
  bench.print(file);
  bench.run_for(30);
  bench.driver.command("M220 S90", bench.t());
  bench.run_for(30);
  REQUIRE_FALSE(bench.over());
  CHECK(std::count(bench.log.begin(), bench.log.end(), "M220 S90") == 1);
}

#include "tests/firmware-io/mock_bench.h"
#include "tests/firmware-io/spaced.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

TEST_CASE("a printer's own settings are known after connecting, in the words of every Marlin", "[dialect]") {
  const std::string firmware = GENERATE("marlin2", "marlin1", "prusa");
  const bool classic = GENERATE(false, true);
  CAPTURE(firmware, classic);
  mock::MotionSettings motion;
  motion.classic_jerk = classic;
  motion.max_speed = {301, 302, 13, 44};
  motion.retract_acceleration = 1234;
  mock::Options options = mock::make_mock().firmware(firmware).motion(motion).build();
  options.volume_mm = {235, 232, 283};
  MockBench bench(options);
  REQUIRE(bench.run_until([&] { return bench.count<LimitsKnown>() == 1; }));
  REQUIRE(bench.count<Connected>() == 1);
  const FirmwareLimits& limits = bench.find<LimitsKnown>()->limits;
  CHECK(limits.max_feed_mm_s == PerAxis{301, 302, 13, 44});
  CHECK(limits.steps_per_mm[2] == motion.steps_per_mm[2]);
  CHECK(limits.max_acceleration_mm_s2[3] == motion.max_acceleration[3]);
  CHECK(limits.retract_acceleration_mm_s2 == 1234);
  CHECK(limits.jerk_mm_s[0].has_value() == classic);
  CHECK(limits.junction_deviation_mm.has_value() != classic);
  CHECK((limits.line_form == LineForm::dense) == (firmware == "marlin2"));
  REQUIRE(limits.volume);
  CHECK(limits.volume->max_mm == std::array<double, 3>{235, 232, 283});
  for (const Event& event : bench.events)
    if (const auto* message = std::get_if<Message>(&event.what))
      CHECK(message->text.find("M92") == std::string::npos);
}

TEST_CASE("each dialect prints a file exactly once", "[dialect]") {
  const std::string firmware =
      GENERATE("marlin2", "marlin1", "marlin10", "prusa", "repetier", "smoothie", "klipper");
  CAPTURE(firmware);
  MockBench bench(mock::make_mock().firmware(firmware).cold_extrusion().instant_moves().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = {"G28"};
  for (int i = 0; i < 300; ++i) file.push_back("G1 X" + std::to_string(i) + " E" + std::to_string(i));
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 120));
  CHECK(bench.count<PrintFinished>() == 1);
  auto moves = bench.log;
  std::erase_if(moves, [](const std::string& line) { return !line.starts_with("G1"); });
  file.erase(file.begin());
  // Marlin 2 gets them without blanks.
  CHECK((moves.front() == "G1X0E0") == (firmware == "marlin2"));
  for (std::string& line : moves) line = spaced(line);
  CHECK(moves == file);
}

TEST_CASE("a text with a colon stops no print, and is shown as it is where that can be", "[dialect]") {
  const std::string firmware = GENERATE("marlin2", "marlin1", "marlin10", "prusa", "repetier", "klipper");
  CAPTURE(firmware);
  MockBench bench(mock::make_mock().firmware(firmware).instant_moves().build());
  REQUIRE(bench.connect());
  bench.print({"G28", "M117 ETL: 00:19", "G1 X10"});
  REQUIRE(bench.run_until([&] { return bench.over(); }, 120));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printer.statistics().resends == 0);
  const auto shown = std::find_if(bench.log.begin(), bench.log.end(),
                                  [](const std::string& line) { return line.starts_with("M117"); });
  REQUIRE(shown != bench.log.end());
  CHECK((*shown == "M117 ETL: 00:19") == (firmware != "marlin10" && firmware != "repetier"));
}

TEST_CASE("a line is sent again though the firmware asks for it again and again meanwhile", "[dialect]") {
  mock::Options options = mock::make_mock().firmware("repetier").cold_extrusion().instant_moves().build();
  mock::Fault damage;
  damage.kind = mock::FaultKind::kGarbleLine;
  damage.trigger = mock::FaultTrigger::kLine;
  damage.at = 40;
  options.faults = {damage};
  voidpath::fw::marlin::DriverOptions driver;
  driver.timing.quiet_s = 0.25;  // longer than the firmware's patience
  MockBench bench(options, driver);
  REQUIRE(bench.connect());
  std::vector<std::string> file;
  for (int i = 0; i < 100; ++i) file.push_back("G1 X" + std::to_string(i));
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 60));
  CHECK(bench.printer.statistics().resends > 1);
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("oks lost by a firmware that says temperatures apart from them cost no half second", "[dialect]") {
  MockBench bench(mock::make_mock()
                      .firmware("repetier")
                      .baud(115200)
                      .round_trip(0.001)
                      .cold_extrusion()
                      .instant_moves()
                      .build());
  REQUIRE(bench.connect());
  std::vector<std::string> file;
  for (int i = 0; i < 100; ++i) file.push_back("G1 X" + std::to_string(i));
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 10; }));
  bool asked = false;
  bench.on_output = [&](const std::string& sent) { asked |= sent.find("M105") != sent.npos; };
  bench.to_host = [&](std::string said) { return asked ? said : ""; };
  const double t = bench.t();
  const int done = bench.count<LineDone>();
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() > done + 12; }));
  CHECK(bench.t() - t < 0.5);
  REQUIRE(bench.run_until([&] { return bench.over(); }));
}

TEST_CASE("a print that the printer starves of filament is paused", "[dialect]") {
  MockBench bench(mock::make_mock().instant_moves().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = {"G1 X10 F600"};
  for (int i = 0; i < 100; ++i) file.push_back("G1 X" + std::to_string(i) + " E" + std::to_string(i));
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  CHECK(bench.find<Paused>()->by_printer);
  CHECK(bench.find<Paused>()->reason == "cold extrusion prevented");
  bench.run_for(10);
  CHECK_FALSE(bench.over());
  CHECK(bench.log.size() < file.size());
}

TEST_CASE("a filament change is a pause by the printer with a question, and its answer ends it",
          "[dialect]") {
  MockBench bench(mock::make_mock().cold_extrusion().instant_moves().emergency_parser().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = {"G1 X10 F600", "M600"};
  for (int i = 0; i < 20; ++i) file.push_back("G1 X" + std::to_string(i));
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  CHECK(bench.find<Paused>()->by_printer);
  bench.run_for(600);
  CHECK_FALSE(bench.over());
  const auto asked = [](const Event& event) {
    const auto* message = std::get_if<Message>(&event.what);
    return message != nullptr && message->asks &&
           message->text == "the printer asks: Paused; M876 S0: Continue";
  };
  CHECK(std::any_of(bench.events.begin(), bench.events.end(), asked));
  bench.driver.command("M876 S0", bench.t());
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<Resumed>() == 1);
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("going on here also ends the wait at the printer's panel", "[dialect]") {
  for (const bool emergency_parser : {false, true}) {
    MockBench bench(
        mock::make_mock().cold_extrusion().instant_moves().emergency_parser(emergency_parser).build());
    REQUIRE(bench.connect());
    std::vector<std::string> file = {"G1 X10 F600", "M600"};
    for (int i = 0; i < 20; ++i) file.push_back("G1 X" + std::to_string(i));
    bench.print(file);
    REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
    bench.run_for(10);
    bench.driver.resume(bench.t());
    REQUIRE(bench.run_until([&] { return bench.over(); }));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(std::count(bench.log.begin(), bench.log.end(), "M108") == 1);
  }
}

TEST_CASE("what is urgent finds room behind a long command of a firmware that is asked for its temperatures",
          "[dialect]") {
  mock::Options options = mock::make_mock().firmware("marlin1").cold_extrusion().instant_moves().build();
  options.dialect.busy = GENERATE(false, true);
  options.leveling_s = 600;
  MockBench bench(options);
  REQUIRE(bench.connect());
  SECTION("a person is there") {
    bench.print({"M104 S60", "G1 X10 F600", "M600", "G1 X1", "G1 X2"});
    REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
    bench.run_for(100);
    bench.driver.resume(bench.t());
    REQUIRE(bench.run_until([&] { return bench.over(); }));
    CHECK(bench.count<PrintFinished>() == 1);
  }
  SECTION("an emergency") {
    bench.print({"M104 S60", "G28", "G29", "G1 X10 F600"});
    bench.run_for(100);
    bench.driver.halt("button", bench.t());
    bench.run_for(1);
    CHECK(bench.printer.halted());
  }
  SECTION("an emergency behind a cancel, or what a user types") {
    bench.print({"M104 S60", "G28", "G29", "G1 X10 F600"});
    bench.run_for(100);
    if (GENERATE(false, true)) {
      bench.driver.cancel("", bench.t());
    } else {
      for (int i = 0; i < 10; ++i) bench.driver.command("M220 S" + std::to_string(100 + i), bench.t());
    }
    bench.run_for(5);
    bench.driver.halt("button", bench.t());
    bench.run_for(1);
    CHECK(bench.printer.halted());
  }
}

TEST_CASE("temperatures are asked for again when a long command is over", "[dialect]") {
  MockBench bench(mock::make_mock().firmware("marlin1").build());
  REQUIRE(bench.connect());
  bench.driver.command("G29", bench.t());
  bench.run_for(60);
  const int told = bench.count<Temperatures>();
  bench.run_for(60);
  CHECK(bench.count<Temperatures>() >= told + 10);
}

TEST_CASE("an emergency stop gets through to a firmware that has no room for it at first", "[dialect]") {
  // No emergency parser, the queue full of slow moves, the ring full to the last byte but a few.
  MockBench bench(mock::make_mock().cold_extrusion().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file;
  for (int i = 0; i < 60; ++i) file.push_back("G1 X" + std::to_string(i % 2 == 0 ? 60 : 0) + " F3000");
  bench.print(file);
  bench.run_for(8);
  REQUIRE(bench.count<LineDone>() > 5);
  bench.driver.halt("button", bench.t());
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 30));
  CHECK(bench.printer.halted());
}

TEST_CASE("a printer that pauses when all is sent is told as a pause, and going on ends it", "[dialect]") {
  mock::Options options = mock::make_mock().cold_extrusion().instant_moves().emergency_parser().build();
  mock::Fault pause;
  pause.kind = mock::FaultKind::kPause;
  std::vector<std::string> file;
  for (int i = 0; i < 20; ++i) file.push_back("G1 X" + std::to_string(i));
  MockBench counted(options);
  REQUIRE(counted.connect());
  counted.print(file);
  REQUIRE(counted.run_until([&] { return counted.over(); }));
  // The last line is M105, behind M400.
  pause.at = static_cast<double>(counted.printer.statistics().lines);
  for (const bool busy : {true, false}) {
    options.dialect.busy = busy;
    options.faults = {pause};
    MockBench bench(options);
    REQUIRE(bench.connect());
    bench.print(file);
    REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
    CHECK(bench.find<Paused>()->by_printer);
    bench.run_for(100);
    REQUIRE_FALSE(bench.over());
    bench.driver.resume(bench.t());
    REQUIRE(bench.run_until([&] { return bench.over(); }));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(bench.count<Resumed>() == 1);
  }
}

TEST_CASE("a cancel ends all of a printer's waits for a person, and leaves room for an emergency",
          "[dialect]") {
  mock::Options options = mock::make_mock().cold_extrusion().instant_moves().build();
  options.emergency_parser = GENERATE(false, true);
  options.dialect.busy = GENERATE(false, true);
  options.pause_waits = options.dialect.busy ? GENERATE(1, 2, 3, 50) : GENERATE(1, 2, 50);
  CAPTURE(options.emergency_parser, options.dialect.busy, options.pause_waits);
  MockBench bench(options);
  REQUIRE(bench.connect());
  bench.print({"M104 S60", "M140 S50", "G1 X10 F600", "M600", "G1 X1"});
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  bench.run_for(100);
  bench.driver.cancel("", bench.t());
  bench.run_for(60);
  if (options.pause_waits == 50) {
    CHECK_FALSE(bench.over());
    bench.driver.halt("button", bench.t());
    bench.run_for(1);
    CHECK(bench.printer.halted());
    return;
  }
  if (!bench.over()) bench.driver.cancel("", bench.t());
  bench.run_for(10);
  CHECK(bench.count<PrintCancelled>() == 1);
  CHECK(bench.printer.hotend().target() == 0);
  CHECK(bench.printer.bed().target() == 0);
}

TEST_CASE("a print on a printer that waits for a person begins as a pause", "[dialect]") {
  mock::Options options = mock::make_mock().cold_extrusion().instant_moves().emergency_parser().build();
  options.dialect.busy = false;
  MockBench bench(options);
  REQUIRE(bench.connect());
  bench.run_for(2);
  bench.driver.command("M600", bench.t());
  bench.run_for(5);
  bench.print({"G90", "G1 X10"});
  REQUIRE(bench.count<Paused>() == 1);
  CHECK_FALSE(bench.find<Paused>()->reason.empty());
  bench.driver.resume(bench.t());
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("a Prusa that has parked goes back before the print goes on, or forgets about it", "[dialect]") {
  const bool cancelled = GENERATE(false, true);
  CAPTURE(cancelled);
  MockBench bench(mock::make_mock().firmware("prusa").cold_extrusion().instant_moves().build());
  REQUIRE(bench.connect());
  std::vector<std::string> file = {"G28"};
  for (int i = 0; i < 40; ++i) file.push_back("G1 X" + std::to_string(i) + " E" + std::to_string(i));
  file.insert(file.begin() + 20, "M601");
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  bench.run_for(600);
  REQUIRE_FALSE(bench.over());
  REQUIRE(bench.log.back() != file[21]);
  if (cancelled) {
    bench.driver.cancel("", bench.t());
  } else {
    bench.driver.resume(bench.t());
  }
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  std::erase_if(bench.log, [](const std::string& line) { return line == "M105" || line == "M108"; });
  const auto parked = std::find(bench.log.begin(), bench.log.end(), "M601");
  REQUIRE(bench.log.end() - parked > 3);
  if (cancelled) {
    CHECK(bench.count<PrintCancelled>() == 1);
    CHECK(bench.log.back() == "M603");
  } else {
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(parked[1] == "M602");
    CHECK(parked[2] == file[21]);
  }
}

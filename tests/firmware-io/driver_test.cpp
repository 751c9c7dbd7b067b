#include "firmware-io/marlin/driver.h"

#include "tests/firmware-io/driver_prints.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

TEST_CASE("the handshake learns who the printer is and has it report temperatures", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  const FirmwareInfo& info = bench.get<Connected>().firmware;
  CHECK(info.name == "Marlin 2.1.2 (Jun 1 2024)");
  CHECK(info.machine == "Model Machine");
  CHECK(info.capabilities.at("AUTOREPORT_TEMP"));
  CHECK_FALSE(info.capabilities.at("EMERGENCY_PARSER"));
  REQUIRE(bench.run_until([&] { return bench.firmware.executed.size() == 6; }));
  CHECK(bench.firmware.executed == Lines{"M110 N0", "M115", "M113 S2", "M503", "M211", "M155 S1"});
  CHECK(bench.raw.at(0) == "\n");
  CHECK(bench.raw.at(1) == "N0 M110 N0*125\n");
}

TEST_CASE("a printer that boots is awaited, and then not any longer than needed", "[driver]") {
  DriverBench bench;
  bench.run_for(1.0);
  CHECK(bench.raw.empty());
  bench.firmware.reset();
  const double booted = bench.t;
  REQUIRE(bench.connect());
  CHECK(bench.t - booted < 1.0);
}

TEST_CASE("garbage before the greeting does no harm", "[driver]") {
  DriverBench bench;
  bench.firmware.receive("\x80\x90 G1 X");
  REQUIRE(bench.connect());
}

TEST_CASE("a mute port is given up with a reason, once", "[driver]") {
  DriverBench bench;
  bench.mute = true;
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }));
  CHECK(bench.get<Disconnected>().reason == "the printer does not answer");
  bench.driver.opened(bench.t);
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }));
  CHECK(bench.count<Disconnected>() == 1);
}

TEST_CASE("a firmware without reports is asked for its temperatures", "[driver]") {
  DriverBench bench({.autoreport = false});
  REQUIRE(bench.run_until([&] { return bench.count<Temperatures>() >= 4; }));
  CHECK(bench.get<Temperatures>().sensors.at("T0").actual_c == Approx(21));
  CHECK(bench.t - 1000 > 10);
  CHECK(bench.t - 1000 < 30);
}

TEST_CASE("a print arrives line by line and ends with the machine at rest", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  const Lines file = Lines{"M140 S60", "G28", "M190 S60", "M109 S200"} + moves(300);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.printed() == file + Lines{"M400"});
  CHECK(bench.count<PrintStarted>() == 1);
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.count<LineDone>() == static_cast<int>(file.size()));
  for (int i = 0; i < bench.count<LineDone>(); ++i)
    CHECK(bench.get<LineDone>(i).index == static_cast<unsigned>(i));
  CHECK(bench.count<LinkStats>() >= 1);
  CHECK(bench.firmware.overflowed == 0);
  CHECK(bench.driver.finished());
}

TEST_CASE("heating waits are timed, and the first motion after them", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(Lines{"M140 S60", "G28", "M190 S60", "G92 E0", "M109 S200"} + moves(5) + Lines{"M109 S210"} +
              moves(5));
  REQUIRE(bench.run_until([&] { return over(bench); }, 200));
  REQUIRE(bench.count<Heating>() == 6);
  for (int i = 0; i < 3; ++i) {
    CHECK(bench.get<Heating>(2 * i).on);
    CHECK_FALSE(bench.get<Heating>(2 * i + 1).on);
    const double took = bench.event_of<Heating>(2 * i + 1).at_s - bench.event_of<Heating>(2 * i).at_s;
    CHECK(took == Approx(20).margin(0.01));
  }
  REQUIRE(bench.count<MotionStarted>() == 2);  // homing between the waits is none
  CHECK(bench.event_of<MotionStarted>(0).at_s >= bench.event_of<Heating>(3).at_s);
  CHECK(bench.event_of<MotionStarted>(0).at_s - bench.event_of<Heating>(3).at_s < 0.001);
  CHECK(bench.event_of<MotionStarted>(1).at_s >= bench.event_of<Heating>(5).at_s);
}

TEST_CASE("the end is when M400 is done, not when the last line is queued", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.duration = [](const std::string& command) { return command == "M400" ? 40.0 : 0.001; };
  bench.print(moves(3));
  REQUIRE(bench.run_until([&] { return over(bench); }, 100));
  const double last = bench.event_of<LineDone>(2).at_s;
  CHECK(bench.event_of<PrintFinished>().at_s - last == Approx(40).margin(0.1));
}

TEST_CASE("pause holds the file back and resume goes on with the next line", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(200));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 50; }));
  bench.driver.pause();
  bench.run_for(30);
  CHECK(bench.count<Paused>() == 1);
  CHECK_FALSE(bench.get<Paused>().by_printer);
  const int done = bench.count<LineDone>();
  CHECK(done < 60);
  bench.run_for(30);
  CHECK(bench.count<LineDone>() == done);
  bench.driver.resume(bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<Resumed>() == 1);
  CHECK(bench.printed() == moves(200) + Lines{"M400"});
}

TEST_CASE("M0 or M25 in a file pauses here and is not forwarded", "[driver]") {
  const std::string pause = GENERATE("M0 change filament", "M25");
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(3) + Lines{pause} + moves(2));
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() == 1; }));
  CHECK(bench.get<Paused>().reason == pause);
  bench.run_for(5);
  CHECK(bench.printed() == moves(3));
  bench.driver.resume(bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.printed() == moves(3) + moves(2) + Lines{"M400"});
}

TEST_CASE("the printer itself pauses, resumes and cancels", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 10; }));
  bench.firmware.replies.push_back("//action:pause filament_runout 0");
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() == 1; }));
  CHECK(bench.get<Paused>().by_printer);
  CHECK(bench.get<Paused>().reason == "filament_runout 0");
  bench.firmware.replies.push_back("//action:resume");
  REQUIRE(bench.run_until([&] { return bench.count<Resumed>() == 1; }));
  bench.firmware.replies.push_back("//action:cancel");
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<PrintCancelled>() == 1);
}

TEST_CASE("a probing that failed pauses the print: a person decides whether it goes on unlevelled",
          "[driver]") {
  const std::string said = GENERATE("Error:Probing Failed", "//action:probe_failed");
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(Lines{"G28", "G29"} + moves(500));
  REQUIRE(bench.run_until([&] { return bench.firmware.front() && *bench.firmware.front() == "G29"; }));
  bench.firmware.replies.push_back(said);
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() == 1; }));
  CHECK(bench.get<Paused>().by_printer);
  bench.run_for(60);
  CHECK(bench.printed() == Lines{"G28", "G29"});
  bench.driver.resume(bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("cancel ends with lift, heaters, fan and motors, in this order", "[driver]") {
  marlin::DriverOptions options;
  options.cancel_gcode = {"G91", "G1 Z10"};
  DriverBench bench({}, options);
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.driver.cancel("enough", bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<PrintCancelled>() == 1);
  const Lines end{"G91", "G1 Z10", "M104 S0", "M140 S0", "M107", "M84"};
  const Lines printed = bench.printed();
  REQUIRE(printed.size() > end.size() + 20);
  REQUIRE(printed.size() < end.size() + 35);
  CHECK(Lines(printed.end() - static_cast<std::ptrdiff_t>(end.size()), printed.end()) == end);
}

TEST_CASE("a print in inches ends in millimetres", "[driver]") {
  const auto [last, ends_in] =
      GENERATE(std::pair(Lines{"G20"}, Lines{"G21"}), std::pair(Lines{"G20", "G21"}, Lines{}));
  const bool stops = GENERATE(false, true);
  marlin::DriverOptions options;
  options.cancel_gcode = {"G91", "G1 Z5"};
  DriverBench bench({}, options);
  REQUIRE(bench.connect());
  bench.print(last + moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  stops ? bench.driver.shut_down(bench.t) : bench.driver.cancel("", bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  const Lines off{"M104 S0", "M140 S0", "M107"}, lift{"G91", "G1 Z5"};
  const Lines wanted = ends_in + (stops ? off + lift : lift + off) + Lines{"M84"};
  const Lines printed = bench.printed();
  REQUIRE(printed.size() > wanted.size() + 20);
  CHECK(Lines(printed.end() - static_cast<std::ptrdiff_t>(wanted.size()), printed.end()) == wanted);
  CHECK(std::count(printed.begin() + 2, printed.end(), "G21") == static_cast<int>(ends_in.size()));
}

TEST_CASE("lines for a cancel may be written as in a file", "[driver]") {
  marlin::DriverOptions options;
  options.cancel_gcode = {"; lift first",
                          "g91 ; relative",
                          "M117 Stopped (by user)",
                          "M0 see to it",
                          "M117 " + std::string(100, 'x'),
                          "M862.3 P" + std::string(100, 'x'),
                          "",
                          "G1 Z10 ; lift",
                          "G1 Z9\nG1 Z8"};
  const bool stops = GENERATE(false, true);
  DriverBench bench({}, options);
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  stops ? bench.driver.shut_down(bench.t) : bench.driver.cancel("enough", bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<PrintCancelled>() == 1);
  const Lines off{"M104 S0", "M140 S0", "M107"};
  const Lines end{
      "G91",  "M117 Stopped by user", "M117 " + std::string(marlin::kMaxPayload - 5, 'x'), "G1 Z10", "G1 Z9",
      "G1 Z8"};
  const Lines wanted = (stops ? off + end : end + off) + Lines{"M84"};
  const Lines printed = bench.printed();
  REQUIRE(printed.size() > wanted.size());
  CHECK(Lines(printed.end() - static_cast<std::ptrdiff_t>(wanted.size()), printed.end()) == wanted);
  CHECK(bench.firmware.refused == 0);
}

TEST_CASE("cancel while heating does not wait for the temperature", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.duration = [](const std::string& command) { return command.starts_with("M109") ? 600.0 : 0.01; };
  bench.print(Lines{"M109 S200"} + moves(10));
  REQUIRE(bench.run_until([&] { return bench.count<Heating>() == 1; }));
  bench.run_for(3);
  const double asked = bench.t;
  bench.driver.cancel("", asked);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.t - asked < 1);
  CHECK_FALSE(bench.get<Heating>(1).on);
  CHECK(bench.printed() == Lines{"M109 S200", "M108", "M104 S0", "M140 S0", "M107", "M84"});
}

TEST_CASE("every hotend is left cold, not the one at work alone", "[driver]") {
  const bool told_at_once = GENERATE(false, true);
  DriverBench bench({.extruders = told_at_once ? 2 : 1});
  REQUIRE(bench.connect());
  if (!told_at_once) {
    bench.firmware.replies.push_back(
        " T:200.00 /210.00 B:60.00 /60.00 T0:200.00 /210.00 T1:205.00 /210.00 @:9");
    bench.firmware.replies.push_back(" T:200.00 /210.00 B:60.00 /60.00 C:31.00 /40.00 @:9");
  }
  const bool stops = GENERATE(false, true);
  auto file = std::make_unique<MemorySource>(Lines{"M104 T1 S210", "T0"} + moves(500));
  if (stops) file->fail_at = 30;
  bench.driver.print(std::move(file), bench.t);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  if (!stops) bench.driver.cancel("", bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  Lines printed = bench.printed();
  if (!stops) printed.pop_back();  // M84
  Lines off{"M104 S0", "M104 T0 S0", "M104 T1 S0", "M140 S0", "M107"};
  if (!told_at_once) off.insert(off.end() - 1, "M141 S0");
  REQUIRE(printed.size() > off.size());
  CHECK(Lines(printed.end() - static_cast<std::ptrdiff_t>(off.size()), printed.end()) == off);
}

TEST_CASE("halt puts M112 on the wire ahead of everything, without and with a number", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.driver.output() += "N77 G1 X1 half a li";
  bench.driver.halt("button", bench.t);
  CHECK(bench.driver.output().starts_with("\nM112\nN"));
  CHECK(bench.driver.take_urgent());
  CHECK_FALSE(bench.driver.take_urgent());
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 10));
  CHECK(bench.firmware.dead);
  CHECK(bench.get<PrintFailed>().reason == "button");
  CHECK(bench.get<Disconnected>().reason == "button");
}

TEST_CASE("the statistics of a print are its own", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  for (int i = 0; i < 2; ++i) {
    bench.print(moves(20));
    REQUIRE(bench.run_until([&] { return bench.count<PrintFinished>() == i + 1; }));
    const auto& stats = bench.get<LinkStats>(bench.count<LinkStats>() - 1);
    CHECK(stats.lines_sent == 22);
    CHECK(stats.resends == 0);
    CHECK(stats.window_bytes == 127);
  }
}

TEST_CASE("a file that breaks off fails the print with the heaters off", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  auto source = std::make_unique<MemorySource>(moves(50));
  source->fail_at = 30;
  bench.driver.print(std::move(source), bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.get<PrintFailed>().reason == "the file went away");
  CHECK(bench.printed() == Lines(moves(30)) + Lines{"M104 S0", "M140 S0", "M107"});
  CHECK_FALSE(bench.driver.closing());
}

TEST_CASE("a user's line goes between the print's own", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(100));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.driver.command("M220 S90 ; faster\r\nM221 S95*17", bench.t);
  bench.driver.command("M110 N5", bench.t);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  Lines printed = bench.printed();
  CHECK(std::count(printed.begin(), printed.end(), "M220 S90") == 1);
  CHECK(std::count(printed.begin(), printed.end(), "M221 S95") == 1);
  std::erase(printed, "M220 S90");
  std::erase(printed, "M221 S95");
  CHECK(printed == moves(100) + Lines{"M400"});
  CHECK(bench.count<LineDone>() == 100);
}

TEST_CASE("print without a printer, or beside a print, is refused", "[driver]") {
  DriverBench bench;
  bench.print(moves(3));
  CHECK(bench.get<PrintFailed>().reason == "the printer is not connected");
  REQUIRE(bench.connect());
  bench.print(moves(300));
  bench.print(moves(3));
  CHECK(bench.get<PrintFailed>(1).reason == "a print is already running");
  REQUIRE(bench.run_until([&] { return bench.count<PrintFinished>() == 1; }));
  CHECK(bench.printed() == moves(300) + Lines{"M400"});
}

TEST_CASE("shutting down turns the heaters off first", "[driver]") {
  marlin::DriverOptions options;
  options.cancel_gcode = {"G1 Z10"};
  DriverBench bench({}, options);
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.driver.shut_down(bench.t);
  REQUIRE(bench.run_until([&] { return bench.driver.finished(); }));
  const Lines printed = bench.printed();
  const Lines end{"M104 S0", "M140 S0", "M107", "G1 Z10", "M84"};
  CHECK(Lines(printed.end() - static_cast<std::ptrdiff_t>(end.size()), printed.end()) == end);
}

TEST_CASE("a print that ends is cold when the heaters' lines have gone, though the last move takes its time",
          "[driver]") {
  const bool stops = GENERATE(false, true);
  marlin::DriverOptions options;
  options.cancel_gcode = {"G1 Z10"};
  DriverBench bench({}, options);
  bench.duration = [](const std::string& command) {
    return command == "M140 S0" || command == "M84" ? 5.0 : 0.001;
  };
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  CHECK_FALSE(bench.driver.cold());
  stops ? bench.driver.shut_down(bench.t) : bench.driver.cancel("", bench.t);
  const double asked = bench.t;
  REQUIRE(bench.run_until([&] { return bench.driver.cold(); }));
  CHECK(bench.t > asked + 4.9);
  CHECK_FALSE(bench.driver.finished());
  REQUIRE(bench.run_until([&] { return bench.driver.finished(); }));
  CHECK(bench.t > asked + 9.9);
}

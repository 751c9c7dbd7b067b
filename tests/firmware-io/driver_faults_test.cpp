#include "firmware-io/marlin/driver.h"
#include "tests/firmware-io/driver_prints.h"

#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

void flip(char& c) { c = static_cast<char>(c ^ 2); }

}  // namespace

TEST_CASE("a printer that restarts in mid-print gets no further line of the file", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  const auto before = bench.firmware.executed.size();
  bench.firmware.reset();
  REQUIRE(bench.run_until([&] { return bench.count<Connected>() == 2 && bench.firmware.reporting; }));
  CHECK(bench.count<PrintFailed>() == 1);
  CHECK(bench.count<Disconnected>() == 1);
  for (std::size_t i = before + 5; i < bench.firmware.executed.size(); ++i) {
    CHECK_FALSE(bench.firmware.executed[i].starts_with("G1"));
  }
  bench.print(moves(3));
  REQUIRE(bench.run_until([&] { return bench.count<PrintFinished>() == 1; }));
}

TEST_CASE("oks lost beside a long command are found out about though they fill the window", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  // The last oks are lost, those of the first two questions after them as well.
  int lost = 0;
  bench.to_host = [&](std::string line) {
    const bool near_end = bench.count<LineDone>() >= 35;
    if (near_end && line.starts_with("ok") && lost < 7) line[0] = 'g', ++lost;
    return line;
  };
  bench.print(moves(40));
  REQUIRE(bench.run_until([&] { return over(bench); }, 3600));
  CHECK(lost == 7);
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printed() == moves(40) + Lines{"M400"});
}

TEST_CASE("a killed firmware fails the print with its own words", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.firmware.dead = true;
  bench.firmware.replies = {"Error:Thermal Runaway, system stopped! Heater_ID: 0"};
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }));
  CHECK(bench.get<PrintFailed>().reason == "Thermal Runaway, system stopped! Heater_ID: 0");
  CHECK(bench.count<Disconnected>() == 1);
  CHECK(bench.driver.output().find("M104 S0\n") != std::string::npos);
  CHECK(bench.driver.output().ends_with("M112\n"));
}

TEST_CASE("a complaint about one command stops nothing", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(50));
  bench.firmware.replies.push_back("Error:?J out of range (0.01 to 0.3)");
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("a vanished port fails the print", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(50));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.driver.lost("cable");
  CHECK(bench.get<PrintFailed>().reason == "connection lost: cable");
  CHECK(bench.get<Disconnected>().reason == "cable");
  CHECK(bench.driver.closing());
}

TEST_CASE("a lost ok costs time and nothing else", "[driver]") {
  for (const int lost : {1, 5, 40, 101, 102}) {
    DriverBench bench;
    REQUIRE(bench.connect());
    int oks = 0;
    bench.to_host = [&](std::string line) { return line == "ok" && ++oks == lost ? std::string() : line; };
    bench.print(moves(100));
    INFO("lost ok " << lost);
    REQUIRE(bench.run_until([&] { return over(bench); }, 120));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(bench.printed() == moves(100) + Lines{"M400"});
    CHECK(bench.count<LineDone>() == 100);
  }
}

TEST_CASE("after an ok too many the end of a print is verified", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.duration = [](const std::string& command) {
    return command == "M400" ? 30.0 : command == "M109 S200" ? 20.0 : 0.01;
  };
  bench.to_host = [&](std::string line) {
    return line == "ok" && bench.firmware.executed.back() == "M109 S200" ? std::string("ok\nok") : line;
  };
  const Lines file = moves(100) + Lines{"M109 S200"} + moves(20);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return over(bench); }, 120));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.firmware.executed.back() == "M105");
  CHECK(bench.printed() == file + Lines{"M400"});
}

TEST_CASE("a doubled ok loses no line", "[driver]") {
  for (int doubled = 1; doubled < 60; doubled += 7) {
    DriverBench bench;
    REQUIRE(bench.connect());
    int oks = 0;
    bench.to_host = [&](std::string line) {
      return line == "ok" && ++oks == doubled ? std::string("ok\nok") : line;
    };
    const Lines file = moves(30) + Lines{"M109 S200"} + moves(20);
    bench.print(file);
    REQUIRE(bench.run_until([&] { return over(bench); }, 120));
    bench.run_for(60);
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(bench.printed() == file + Lines{"M400"});
  }
}

TEST_CASE("a storm of faults in mid-print leaves each line once", "[driver]") {
  int undetectable = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    DriverBench bench({.resend_says_ok = seed % 2 == 0, .advanced_ok = seed % 3 == 0});
    REQUIRE(bench.connect());
    std::mt19937 random(seed);
    bench.to_printer = [&](std::string line) {
      if (random() % 12 != 0 || line.size() < 4) return line;
      if (random() % 3 == 0)
        line.pop_back();
      else if (random() % 2 == 0)
        flip(line[1 + random() % (line.size() - 2)]);
      else
        line.clear();
      return line;
    };
    bench.to_host = [&](std::string line) { return random() % 40 == 0 ? std::string() : line; };
    bench.print(Lines{"G28", "M109 S200"} + moves(150));
    INFO("seed " << seed);
    REQUIRE(bench.run_until([&] { return over(bench); }, 2000));
    const Lines all = Lines{"G28", "M109 S200"} + moves(150) + Lines{"M400"};
    undetectable += bench.firmware.undetectable;
    if (bench.firmware.undetectable > 0) continue;
    if (bench.count<PrintFinished>() == 1) {
      CHECK(bench.printed() == all);
      CHECK(bench.get<LinkStats>(bench.count<LinkStats>() - 1).resends > 0);
    } else {
      CHECK_FALSE(bench.get<PrintFailed>().reason.empty());
    }
  }
  CHECK(undetectable < 4);
}

TEST_CASE("one flipped byte in a line costs less than half a second", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  int sent = 0;
  bench.to_printer = [&](std::string line) {
    if (++sent == 60) flip(line[8]);
    return line;
  };
  bench.print(moves(200));
  const double begun = bench.t;
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.printed() == moves(200) + Lines{"M400"});
  CHECK(bench.t - begun < 201 * 0.01 + 0.5);
}

TEST_CASE("a printer that never stops talking gets what it asks for again", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(200));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 20; }));
  const int last = std::stoi(bench.raw.back().substr(1));
  bench.driver.output().clear();
  bench.driver.received("Error:checksum mismatch, Last Line: " + std::to_string(last - 1) +
                            "\nResend: " + std::to_string(last) + "\nok\n",
                        bench.t);
  const double asked = bench.t;
  while (bench.driver.output().empty() && bench.t < asked + 60) {
    bench.t += 0.05;
    if (bench.t >= bench.driver.deadline()) bench.driver.elapsed(bench.t);
    bench.driver.received("echo:still here\n", bench.t);
  }
  CHECK(bench.t - asked < 3);
  CHECK(bench.driver.output().starts_with("N" + std::to_string(last) + "G1"));
}

TEST_CASE("a printer that falls silent is noticed and the print failed", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.mute = true;
  REQUIRE(bench.run_until([&] { return over(bench); }, 400));
  CHECK(bench.get<PrintFailed>().reason == "the printer no longer answers");
  CHECK(bench.get<Disconnected>().reason == "the printer no longer answers");
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 20));
  CHECK_FALSE(bench.driver.halt_heard());
}

TEST_CASE("a printer that is given up is told M112 until it has room for it", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() == 20; }));
  bench.mute = true;
  int said = 0;
  bench.to_printer = [&](const std::string& line) {
    return line.find("M112") != line.npos && ++said <= 6 ? std::string() : line;
  };
  REQUIRE(bench.run_until([&] { return over(bench); }, 400));
  CHECK_FALSE(bench.driver.finished());
  bench.mute = false;
  REQUIRE(bench.run_until([&] { return bench.driver.finished(); }, 5));
  CHECK(bench.firmware.dead);
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 5));
  CHECK(said == 8);  // each time without a number and with one
  CHECK(bench.driver.halt_heard());
  bench.driver.opened(bench.t);
  CHECK_FALSE(bench.driver.halt_heard());
}

TEST_CASE("a long command with busy, and one in silence, are waited for", "[driver]") {
  for (const bool says_busy : {true, false}) {
    DriverBench bench;
    bench.says_busy = says_busy;
    REQUIRE(bench.connect());
    bench.duration = [](const std::string& command) { return command == "G29" ? 600.0 : 0.01; };
    const Lines file = Lines{"G28", "G29"} + moves(20);
    bench.print(file);
    REQUIRE(bench.run_until([&] { return over(bench); }, 700));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(bench.printed() == file + Lines{"M400"});
    CHECK(bench.firmware.overflowed == 0);
    const auto probes = std::count(bench.firmware.executed.begin(), bench.firmware.executed.end(), "M105");
    CHECK(probes <= (says_busy ? 1 : 3));  // one is the last line of every print
  }
}

TEST_CASE("a person's pause at the printer stops the timers", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.says_busy = false;
  bench.duration = [](const std::string& command) { return command == "M600" ? 5000.0 : 0.01; };
  bench.print(Lines{"M600"} + moves(5));
  bench.run_for(1);
  bench.firmware.replies.push_back("echo:busy: paused for user");
  REQUIRE(bench.run_until([&] { return over(bench); }, 6000));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("a change of filament that a mute printer began is waited for, also when it has to heat again",
          "[driver]") {
  const bool reheats = GENERATE(false, true);
  CAPTURE(reheats);
  DriverBench bench({.autoreport = false});
  bench.says_busy = false;
  REQUIRE(bench.run_until([&] { return bench.count<Connected>() > 0; }));
  bench.run_for(1);
  const Lines file = moves(60);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 10; }));
  // The sensor says so while a move runs, whose ok still comes; then the firmware's own M600 stands before
  // the file's next line.
  const int done = bench.count<LineDone>();
  bench.firmware.replies.push_back("//action:paused filament_runout 0");
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() > done; }));
  const double began = bench.t;
  bench.duration = [](const std::string&) { return 2000.0; };
  bench.firmware.replies.push_back("//action:paused");
  bench.run_for(600);
  while (reheats && bench.t < began + 660) {
    bench.firmware.replies.push_back(" T:150.00 /200.00 B:60.00 /60.00 @:127 B@:0 W:?");
    bench.run_for(1);
  }
  bench.run_for(began + 1990 - bench.t);
  CHECK_FALSE(over(bench));
  CHECK(bench.count<Resumed>() == 0);
  bench.duration = [](const std::string&) { return 0.01; };
  bench.firmware.replies.push_back("//action:resumed");
  REQUIRE(bench.run_until([&] { return over(bench); }, 100));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.count<Paused>() == 1);
  CHECK(bench.count<Resumed>() == 1);
  CHECK(bench.printed() == file + Lines{"M400"});
}

TEST_CASE("a boot whose start was not heard ends the print", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(40));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 10; }));
  bench.to_host = [](std::string line) { return line == "start" ? "sta" : line; };
  bench.firmware.reset();
  const auto before = bench.printed().size();
  REQUIRE(bench.run_until([&] { return over(bench); }));
  REQUIRE(bench.count<PrintFailed>() == 1);
  CHECK(bench.get<PrintFailed>().reason.find("restarted") != std::string::npos);
  CHECK(bench.printed().size() == before);
  CHECK(bench.run_until([&] { return bench.count<Connected>() == 2; }));
}

TEST_CASE("that all oks in flight are lost costs no half second", "[driver]") {
  DriverBench bench;
  REQUIRE(bench.connect());
  bench.print(moves(100));
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() >= 10; }));
  int lost = 0;
  bench.to_host = [&](std::string line) { return line == "ok" && lost++ < 8 ? "" : line; };
  const double t = bench.t;
  const int done = bench.count<LineDone>();
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() > done + 8; }));
  CHECK(bench.t - t < 0.5);
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.printed().size() == 101);
}

TEST_CASE("a silent levelling run that a doubled ok seems to have ended is waited for", "[driver]") {
  for (const bool advanced : {false, true}) {
    DriverBench bench({.advanced_ok = advanced});
    bench.says_busy = false;
    REQUIRE(bench.connect());
    bench.duration = [](const std::string& command) { return command == "G29" ? 600.0 : 0.01; };
    const Lines file = moves(3) + Lines{"G29"} + moves(20);
    bench.to_host = [&](std::string line) {
      const bool before = line.starts_with("ok") && bench.firmware.executed.back() == file[2];
      return before ? "ok\nok" : line;
    };
    bench.print(file);
    REQUIRE(bench.run_until([&] { return over(bench); }, 700));
    CHECK(bench.count<PrintFinished>() == 1);
    CHECK(bench.printed() == file + Lines{"M400"});
    CHECK(bench.firmware.overflowed == 0);
  }
}

TEST_CASE("a late answer to an earlier question does not end a print whose oks ran ahead", "[driver]") {
  DriverBench bench({.autoreport = false});
  REQUIRE(bench.run_until([&] { return bench.count<Connected>() > 0; }));
  bench.run_for(1);
  // The wait is long enough for the poll of temperatures to fall into it; the oks before it all come twice.
  bench.duration = [](const std::string& command) { return command == "G4 P9000" ? 9.0 : 0.01; };
  bench.to_host = [&](std::string line) {
    return line == "ok" && bench.firmware.executed.back().starts_with("G1") ? "ok\nok" : line;
  };
  const Lines file = moves(13) + Lines{"G4 P9000"} + moves(20);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return over(bench); }, 120));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.printed() == file + Lines{"M400"});
}

#include "tests/firmware-io/s3g_prints.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

TEST_CASE("the greeting learns which firmware it is", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  CHECK(std::get<Connected>(bench.first<Connected>()->what).firmware.name == "Sailfish 7.7");
  CHECK(bench.t < 0.1);
  mock::S3gOptions old = real_wire();
  old.advanced_version = false;
  old.boot_s = 2.5;
  S3gBench other(old);
  REQUIRE(other.connect());
  CHECK(std::get<Connected>(other.first<Connected>()->what).firmware.name == "MakerBot 7.7");
}

TEST_CASE("a port on which nobody answers is given up", "[s3g]") {
  mock::S3gOptions dead;
  dead.boot_s = 1e9;
  S3gBench bench(dead);
  REQUIRE(bench.run_until([&] { return bench.driver.closing(); }, 60));
  CHECK(bench.count<Disconnected>() == 1);
}

TEST_CASE("a print is executed as it stands, command for command", "[s3g]") {
  for (const bool wired : {false, true}) {
    S3gBench bench(wired ? real_wire() : mock::S3gOptions{});
    REQUIRE(bench.connect());
    const Lines file = kStart + moves(400) + kEnd;
    REQUIRE(bench.print_through(file));
    CHECK(bench.failure().empty());
    REQUIRE(bench.count<PrintFinished>() == 1);
    check_executed(bench, file);
    CHECK(bench.count<LineDone>() == static_cast<int>(file.size()));
    CHECK(bench.count<PrintStarted>() == 1);
    CHECK(bench.count<Heating>() == 2);
    CHECK(bench.mock.drained());
    const auto last =
        std::get<LinkStats>(std::find_if(bench.events.rbegin(), bench.events.rend(), [](const Event& e) {
                              return std::holds_alternative<LinkStats>(e.what);
                            })->what);
    CHECK(last.resends == 0);
  }
}

TEST_CASE("a wire faster than it was said to be costs no wait and prints as ever", "[s3g]") {
  s3g::DriverOptions options;
  options.timing.byte_s = 10 / 115200.0;
  S3gBench bench(mock::S3gOptions{}, options);
  REQUIRE(bench.connect());
  CHECK(bench.t < 0.1);
  const Lines file = kStart + moves(200) + kEnd;
  REQUIRE(bench.print_through(file));
  REQUIRE(bench.count<PrintFinished>() == 1);
  check_executed(bench, file);
  CHECK(std::get<LinkStats>(bench.first<LinkStats>()->what).resends == 0);
}

TEST_CASE("a printer stuck at one command for hours is stopped", "[s3g]") {
  S3gBench bench;
  REQUIRE(bench.connect());
  bench.print(kStart + moves(20) + Lines{"G4 S60"} + moves(20) + kEnd);
  REQUIRE(bench.run_until([&] { return bench.executed.size() > 30; }));
  // Damage that its checksum did not show made a move out of something: half a kilometre.
  const auto far = s3g::Payload(s3g::Command::move).i32(44'000'000).i32(0).i32(0).i32(0).i32(0);
  bench.mock.feed(s3g::frame(s3g::Payload(far).u32(2000).u8(31).f32(500'000).u16(1450).bytes()));
  bench.mock.take_output();
  REQUIRE(bench.run_until([&] { return bench.over(); }, 3 * 3600));
  CHECK_THAT(bench.failure(), Catch::Contains("stuck at one command"));
  CHECK(bench.t > 2 * 3600);
  CHECK(bench.run_until([&] { return bench.mock.aborts() > 0; }, 1));
  // A pause is no such thing, nor is a dwell.
  S3gBench patient(real_wire());
  REQUIRE(patient.connect());
  patient.print(kStart + moves(40) + Lines{"G4 S4200"} + moves(20) + kEnd);
  REQUIRE(patient.run_until([&] { return patient.executed.size() > 30; }));
  patient.driver.pause();
  patient.run_for(5 * 3600);
  patient.driver.resume(patient.t);
  REQUIRE(patient.run_until([&] { return patient.over(); }, 3 * 3600));
  CHECK(patient.count<PrintFinished>() == 1);
}

TEST_CASE("the end of a print is known within a few hundredths of a second", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  double rested = 0;
  bench.each_step = [&] {
    if (!bench.mock.drained() || bench.mock.queued_bytes() > 0) rested = bench.t;
  };
  REQUIRE(bench.print_through(kStart + moves(100)));
  CHECK(bench.first<PrintFinished>()->at_s - rested < 0.05);
}

TEST_CASE("motion begins, for the clock, when the heating has ended", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_through(kStart + moves(20)));
  double heated = 0, moved = 0;
  for (const Event& event : bench.events) {
    if (const auto* heating = std::get_if<Heating>(&event.what); heating && !heating->on) heated = event.at_s;
    if (std::holds_alternative<MotionStarted>(event.what)) moved = event.at_s;
  }
  CHECK(heated > 10);
  CHECK(moved >= heated);
  CHECK(moved - heated < 0.1);
}

TEST_CASE("short moves go out at the speed of the wire", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const Lines file = Lines{"G92 X0 Y0 Z0", "M83"} + short_moves(5000);
  REQUIRE(bench.print_into(file, 100));
  const double begun = bench.t;
  const std::size_t before = bench.executed.size();
  REQUIRE(bench.run_until([&] { return bench.executed.size() > 4900; }));
  CHECK(static_cast<double>(bench.executed.size() - before) / (bench.t - begun) > 220);
}

TEST_CASE("every fault of the wire: each command exactly once, in order", "[s3g]") {
  struct Kind {
    mock::FaultKind kind;
    bool outwards;
    double probability;
  };
  const Kind kinds[] = {
      {mock::FaultKind::kFlipByte, false, 1e-3},   {mock::FaultKind::kFlipByte, true, 1e-2},
      {mock::FaultKind::kDropByte, false, 1e-3},   {mock::FaultKind::kDropByte, true, 1e-2},
      {mock::FaultKind::kInsertByte, false, 1e-3}, {mock::FaultKind::kInsertByte, true, 1e-2},
      {mock::FaultKind::kDoubleByte, false, 1e-3}, {mock::FaultKind::kDoubleByte, true, 1e-2},
      {mock::FaultKind::kDropLine, false, 2e-2},   {mock::FaultKind::kGarbleLine, false, 2e-2},
      {mock::FaultKind::kLoseOk, true, 2e-2},      {mock::FaultKind::kGarbleOk, true, 2e-2},
      {mock::FaultKind::kDoubleOk, true, 2e-2}};
  for (const bool counts : {true, false}) {
    for (const Kind& kind : kinds) {
      for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        mock::S3gOptions o = real_wire();
        o.counts_lines = counts;
        o.seed = seed;
        mock::Fault fault;
        fault.kind = kind.kind;
        fault.trigger = natural_trigger(kind.kind);
        fault.outwards = kind.outwards;
        fault.probability = kind.probability;
        o.faults = {fault};
        S3gBench bench(o);
        INFO("kind " << static_cast<int>(kind.kind) << (kind.outwards ? " out" : " in") << ", seed " << seed
                     << (counts ? "" : ", no line counter"));
        REQUIRE(bench.connect());
        const Lines file = kStart + moves(60, seed) + kEnd;
        REQUIRE(bench.print_through(file));
        INFO(bench.failure());
        REQUIRE(bench.count<PrintFinished>() == 1);
        // Idempotent commands may come twice, and never does a move of filament.
        const Lines want = expected(file);
        std::size_t at = 0;
        for (const std::string& payload : bench.executed) {
          if (at < want.size() && payload == want[at]) {
            ++at;
          } else {
            INFO("command " << at << ": " << s3g::hex(payload));
            REQUIRE(at > 0);
            REQUIRE(payload == want[at - 1]);
            const bool moves_filament =
                static_cast<unsigned char>(payload[0]) == 155 &&
                (s3g::little_endian(payload, 13, 4) | s3g::little_endian(payload, 17, 4)) != 0;
            REQUIRE_FALSE(moves_filament);
          }
        }
        std::string last_words;
        const auto dialogue = bench.recorder.lines();
        for (std::size_t i = dialogue.size() < 20 ? 0 : dialogue.size() - 20; i < dialogue.size(); ++i) {
          last_words += dialogue[i] + "\n";
        }
        INFO(last_words);
        REQUIRE(at == want.size());
        CHECK(bench.mock.violations().empty());
        CHECK_FALSE(bench.said("may have run twice"));
      }
    }
  }
}

TEST_CASE("heaters shut down with nothing left to send are noticed before the print counts as finished",
          "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  bench.print(kStart + moves(30) + kEnd);
  // The last answer to the board's status is from before, and all has been queued.
  REQUIRE(bench.run_until([&] { return bench.count<LineDone>() > 30 && bench.mock.queued_bytes() > 0; }));
  REQUIRE(bench.run_until([&] { return bench.mock.drained() && bench.mock.queued_bytes() == 0; }));
  REQUIRE_FALSE(bench.over());
  bench.mock.shut_heaters_down();
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<PrintFinished>() == 0);
  CHECK(bench.failure().find("heaters") != std::string::npos);
}

TEST_CASE("a tool that is not there does not end the session", "[s3g]") {
  s3g::DriverOptions options;
  options.machine.extruders = 2;
  S3gBench bench(real_wire(), options);
  REQUIRE(bench.connect());
  bench.run_for(60);
  CHECK(bench.count<Disconnected>() == 0);
  CHECK(bench.count<Temperatures>() > 5);
  const Lines file = kStart + moves(30) + kEnd;
  REQUIRE(bench.print_through(file));
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("a heater that fails ends the print with that reason", "[s3g]") {
  S3gBench bench(
      real_wire({{.kind = mock::FaultKind::kDeadHeater, .at = 20, .trigger = mock::FaultTrigger::kTime}}));
  REQUIRE(bench.connect());
  REQUIRE(bench.print_through(kStart + moves(3000) + kEnd));
  CHECK_THAT(bench.failure(), Catch::Contains("heater"));
}

TEST_CASE("heaters shut down at any moment fail the print, and nobody takes it for a cancel", "[s3g]") {
  for (int i = 0; i < 30; ++i) {
    S3gBench bench(real_wire());
    REQUIRE(bench.connect());
    REQUIRE(bench.print_into(kStart + moves(300) + kEnd, 100));
    bench.run_for(i * 0.0013);
    bench.mock.shut_heaters_down();
    REQUIRE(bench.run_until([&] { return bench.over(); }, 5));
    CHECK(bench.count<PrintCancelled>() == 0);
    CHECK_THAT(bench.failure(), Catch::Contains("heaters"));
    CHECK_FALSE(bench.said("panel"));
  }
}

TEST_CASE("a printer with its heaters shut down answers nothing else, and the loss is named by that",
          "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  bench.run_for(2);
  bench.mock.shut_heaters_down();
  const auto closed = [&] { return bench.driver.closing(); };
  REQUIRE(bench.run_until(closed, 30));
  REQUIRE(bench.count<Disconnected>() == 1);
  CHECK_THAT(std::get<Disconnected>(bench.first<Disconnected>()->what).reason, Catch::Contains("heaters"));
  // The same as long as it stays so, told once.
  bench.driver.opened(bench.t);
  REQUIRE(bench.run_until(closed, 2));
  CHECK(bench.count<Disconnected>() == 1);
  S3gBench other(real_wire());
  other.mock.shut_heaters_down();
  REQUIRE(other.run_until([&] { return other.driver.closing(); }, 5));
  CHECK_THAT(std::get<Disconnected>(other.first<Disconnected>()->what).reason, Catch::Contains("heaters"));
}

TEST_CASE("a printer that prints from its card refuses, and says so", "[s3g]") {
  S3gBench bench(real_wire(
      {{.kind = mock::FaultKind::kBusy, .at = 1, .trigger = mock::FaultTrigger::kTime, .seconds = 100}}));
  REQUIRE(bench.connect());
  bench.run_for(2);
  REQUIRE(bench.print_through(kStart));
  CHECK_THAT(bench.failure(), Catch::Contains("card"));
}

TEST_CASE("a restart in mid-print fails the print", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(300), 100));
  bench.mock.reset();
  REQUIRE(bench.run_until([&] { return bench.over(); }, 10));
  CHECK_THAT(bench.failure(), Catch::Contains("restarted"));
}

TEST_CASE("a restart near a print's end, where nothing more may be polled, fails it as well", "[s3g]") {
  S3gBench whole(real_wire());
  REQUIRE(whole.connect());
  whole.executed.clear();
  REQUIRE(whole.print_through(kStart + moves(30)));
  REQUIRE(whole.count<PrintFinished>() == 1);
  for (std::size_t before_end = 1; before_end < 12; ++before_end) {
    S3gBench bench(real_wire());
    REQUIRE(bench.connect());
    bench.executed.clear();
    bench.print(kStart + moves(30));
    REQUIRE(bench.run_until([&] { return bench.executed.size() + before_end >= whole.executed.size(); }));
    bench.mock.reset();
    INFO(before_end << " commands before the end");
    REQUIRE(bench.run_until([&] { return bench.over(); }, 60));
    CHECK_THAT(bench.failure(), Catch::Contains("restarted"));
  }
}

TEST_CASE("a restart right before the build's end is no finished print", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  const std::string end = s3g::frame(s3g::Encoder(s3g::Machine()).build_end().payload);
  bench.on_output = [&](const std::string& bytes) {
    if (bytes == end) bench.mock.reset();
  };
  REQUIRE(bench.print_through(kStart + moves(30)));
  REQUIRE(bench.mock.statistics().resets == 1);
  CHECK_THAT(bench.failure(), Catch::Contains("restarted"));
}

TEST_CASE("silence in mid-print ends it with a reason", "[s3g]") {
  S3gBench bench(real_wire(
      {{.kind = mock::FaultKind::kSilence, .at = 60, .trigger = mock::FaultTrigger::kTime, .seconds = 1e6}}));
  REQUIRE(bench.connect());
  REQUIRE(bench.print_through(kStart + moves(3000)));
  CHECK_THAT(bench.failure(), Catch::Contains("no longer answers"));
  CHECK(bench.count<Disconnected>() == 1);
  CHECK(bench.run_until([&] { return bench.driver.closing(); }, 3));
}

TEST_CASE("a short silence is waited out", "[s3g]") {
  S3gBench bench(real_wire(
      {{.kind = mock::FaultKind::kSilence, .at = 60, .trigger = mock::FaultTrigger::kTime, .seconds = 5}}));
  REQUIRE(bench.connect());
  const Lines file = kStart + moves(200) + kEnd;
  REQUIRE(bench.print_through(file));
  REQUIRE(bench.failure().empty());
  check_executed(bench, file);
}

TEST_CASE("a line that cannot be translated ends the print, heaters off", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_through(kStart + Lines{"G5 X1 Y1"} + moves(10)));
  CHECK_THAT(bench.failure(), Catch::StartsWith("line 11: G5 X1 Y1: "));
  bench.run_for(5);
  CHECK(bench.mock.hotend().target() == 0);
}

TEST_CASE("temperatures are told while idle, heating and printing", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  bench.run_for(11);
  CHECK(bench.count<Temperatures>() >= 2);
  bench.forget_events();
  bench.print(kStart + moves(3000));
  bench.run_for(60);
  CHECK(bench.count<Temperatures>() >= 20);
  const auto& last =
      std::get<Temperatures>(std::find_if(bench.events.rbegin(), bench.events.rend(), [](const Event& e) {
                               return std::holds_alternative<Temperatures>(e.what);
                             })->what);
  CHECK(last.sensors.at("T0").target_c == 100);
  CHECK(last.sensors.at("T0").actual_c == Approx(100).margin(3));
}

TEST_CASE("a command of the user's goes between the print's own", "[s3g]") {
  S3gBench bench(real_wire());
  REQUIRE(bench.connect());
  REQUIRE(bench.print_into(kStart + moves(100) + kEnd, 60));
  bench.driver.command("M104 S120", bench.t);
  bench.driver.command("G5", bench.t);
  REQUIRE(bench.run_until([&] { return bench.mock.hotend().target() == 120; }, 30));
  CHECK(bench.said("not sent: G5"));
  bench.driver.command("M104 S130\nM106 S0\r\n", bench.t);
  REQUIRE(bench.run_until([&] { return bench.mock.hotend().target() == 130; }, 30));
}

TEST_CASE("a command that may have run twice is in the record", "[s3g]") {
  const auto doubts = [](const std::string& line, bool tells_position) {
    mock::S3gOptions o =
        real_wire({{.kind = mock::FaultKind::kLoseOk, .at = 40, .trigger = mock::FaultTrigger::kOk}});
    o.counts_lines = false;
    o.tells_position = tells_position;
    S3gBench bench(o);
    REQUIRE(bench.connect());
    REQUIRE(bench.print_through(Lines{"M136", "G92 X0 Y0 Z0", "M83"} + Lines(80, line)));
    REQUIRE(bench.count<PrintFinished>() == 1);
    const auto last = std::find_if(bench.events.rbegin(), bench.events.rend(),
                                   [](const Event& e) { return std::holds_alternative<LinkStats>(e.what); });
    CHECK(bench.said("may have run twice") == (std::get<LinkStats>(last->what).doubts > 0));
    return std::get<LinkStats>(last->what).doubts;
  };
  CHECK(doubts("G1 E1", true) == 0);
  CHECK(doubts("G1 E1", false) == 1);
  CHECK(doubts("G4 P100", true) == 1);
}

#include "tests/firmware-io/mock_bench.h"

#include <catch2/catch.hpp>

/// Firmware whose ok says "in the queue", as Repetier's.
using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

mock::Options repetier(std::size_t queue = 4) {
  return mock::make_mock()
      .firmware("repetier")
      .queue(queue)
      .baud(115200)
      .round_trip(0.001)
      .cold_extrusion()
      .build();
}

const std::vector<std::string> kHeated = {"G28", "M190 S60", "G1 X10 F1200", "G1 X20", "G1 X10"};

/// When each kind of event came, on the printer's clock.
template <typename T>
double time_of(const MockBench& bench) {
  for (const Event& event : bench.events)
    if (std::holds_alternative<T>(event.what)) return event.at_s - 1000;
  return -1;
}

/// When the printer came to each command.
struct Executed {
  explicit Executed(MockBench& bench) {
    bench.printer.on_command([this, &bench](std::string_view command) {
      bench.log.emplace_back(command);
      times.emplace_back(bench.printer.now());
    });
  }
  double at(const MockBench& bench, std::string_view begin) const {
    for (std::size_t i = 0; i < times.size(); ++i)
      if (bench.log[i].starts_with(begin)) return times[i];
    return -1;
  }
  std::vector<double> times;
};

}  // namespace

TEST_CASE("a heating ends with the heating, not when it is in the queue", "[enqueue]") {
  const std::size_t queue = GENERATE(1u, 2u, 4u);
  CAPTURE(queue);
  MockBench bench(repetier(queue));
  Executed executed(bench);
  REQUIRE(bench.connect());
  bench.print(kHeated);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 3600));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.count<LineDone>() == static_cast<int>(kHeated.size()));
  const double heated_s = bench.printer.statistics().heating_s;
  REQUIRE(heated_s > 30);
  // The first move is executed as soon as it is there.
  CHECK(time_of<MotionStarted>(bench) == Approx(executed.at(bench, "G1")).margin(0.1));
  CHECK(time_of<MotionStarted>(bench) >= executed.at(bench, "M190") + heated_s);
  CHECK(time_of<MotionStarted>(bench) < executed.at(bench, "M190") + heated_s + 3);
  // Nobody wants to read what was asked for by the link.
  for (const Event& event : bench.events)
    if (const auto* message = std::get_if<Message>(&event.what))
      CHECK(message->text.find("Repetier") == message->text.npos);
}

TEST_CASE("a print is measured alike whenever a firmware says ok", "[enqueue]") {
  std::vector<std::string> file = {"G28", "M104 S120", "M190 S60", "M109 S120"};
  for (int i = 0; i < 60; ++i) file.push_back(i % 2 == 0 ? "G1 X50 F3000" : "G1 X0");
  file.insert(file.begin() + 30, "G4 S5");
  struct Measured {
    double heating_s = 0, moving_s = 0;
  };
  const auto measured = [&](const std::string& firmware) {
    mock::Options options = repetier();
    options.dialect = *mock::find_dialect(firmware);
    MockBench bench(options);
    REQUIRE(bench.connect());
    bench.print(file);
    REQUIRE(bench.run_until([&] { return bench.over(); }, 3600));
    Measured sum;
    for (const Event& event : bench.events) {
      if (const auto* heating = std::get_if<Heating>(&event.what))
        sum.heating_s += heating->on ? -event.at_s : event.at_s;
      if (std::holds_alternative<MotionStarted>(event.what)) sum.moving_s = -event.at_s;
      if (std::holds_alternative<PrintFinished>(event.what)) sum.moving_s += event.at_s;
    }
    return sum;
  };
  const Measured early = measured("repetier"), late = measured("marlin1");
  CHECK(late.heating_s > 60);
  CHECK(late.moving_s > 60);
  CHECK(early.heating_s == Approx(late.heating_s).margin(1));
  CHECK(early.moving_s == Approx(late.moving_s).margin(0.5));
}

TEST_CASE("an emergency stop is heard during a long command that has its ok, where the queue has room",
          "[enqueue]") {
  mock::Options options = repetier();
  options.leveling_s = 600;
  MockBench bench(options);
  REQUIRE(bench.connect());
  const std::string command = GENERATE("M190 S60", "G29", "M303 E0 S200");
  CAPTURE(command);
  SECTION("of a file") { bench.print({"M104 S60", "G28", command, "G1 X10 F600", "G1 X20", "G1 X0"}); }
  SECTION("of a user") {
    bench.driver.command("M104 S60", bench.t());
    bench.driver.command("G28", bench.t());
    bench.driver.command(command, bench.t());
    bench.driver.command("M106 S9", bench.t());
    bench.driver.command("M106 S8", bench.t());
    bench.driver.command("M106 S7", bench.t());
  }
  bench.run_for(50);
  REQUIRE(bench.log.back() == command);
  bench.driver.halt("button", bench.t());
  bench.run_for(1);
  CHECK(bench.printer.halted());
}

TEST_CASE("a cancel ends a heating that has its ok, in a firmware that reads meanwhile", "[enqueue]") {
  MockBench bench(repetier());
  REQUIRE(bench.connect());
  bench.print({"G28", "M190 S100", "G1 X10 F600"});
  bench.run_for(20);
  REQUIRE(bench.log.back().starts_with("M190"));
  bench.driver.cancel("", bench.t());
  REQUIRE(bench.run_until([&] { return bench.over(); }, 5));
  CHECK(bench.count<PrintCancelled>() == 1);
}

TEST_CASE("a print goes on when the person was at the printer's panel", "[enqueue]") {
  mock::Options options = repetier();
  options.dialect.busy = options.dialect.autoreport = true;
  options.dialect.identity += "Cap:AUTOREPORT_TEMP:1\n";
  MockBench bench(options);
  REQUIRE(bench.connect());
  bench.to_host = [](std::string said) {
    const auto action = said.find("//action");
    return action == said.npos ? said : said.substr(0, action);
  };
  bench.print({"G28", "G1 X10 F1200", "M600", "G1 X20"});
  REQUIRE(bench.run_until([&] { return bench.count<Paused>() > 0; }));
  bench.run_for(100);
  REQUIRE_FALSE(bench.over());
  bench.printer.press_button();
  REQUIRE(bench.run_until([&] { return bench.over(); }));
  CHECK(bench.count<Resumed>() == 1);
  CHECK(bench.count<PrintFinished>() == 1);
}

TEST_CASE("the end of a long command is known though what tells it is lost", "[enqueue]") {
  mock::Options options = repetier();
  options.dialect.wait_when_idle = GENERATE(false, true);
  const bool reports = GENERATE(false, true);
  const int lost = GENERATE(1, 2, 1000);
  CAPTURE(options.dialect.wait_when_idle, reports, lost);
  if (reports) {
    options.dialect.autoreport = true;
    options.dialect.identity += "Cap:AUTOREPORT_TEMP:1\n";
  }
  MockBench bench(options);
  Executed executed(bench);
  REQUIRE(bench.connect());
  int losses = 0;
  bench.to_host = [&](std::string said) {
    const auto name = said.find("FIRMWARE_NAME");
    if (name != said.npos && losses < lost) said[name] = 'f', ++losses;
    return said;
  };
  bench.print(kHeated);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 3 * 3600));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(losses > 0);
  // The first loss is the homing's.
  const double heating_t = executed.at(bench, "M190");
  if (options.dialect.wait_when_idle) {
    CHECK(heating_t < 20);
  } else if (!reports && lost == 1) {
    CHECK(heating_t < 60);
  }
  CHECK(time_of<MotionStarted>(bench) >= heating_t + bench.printer.statistics().heating_s);
}

TEST_CASE("a long command and what asks for its end outlive a bad wire", "[enqueue]") {
  mock::Options options = repetier();
  options.leveling_s = 40;
  options.seed = GENERATE(range<std::uint64_t>(1, 9));
  mock::Fault fault;
  fault.kind = GENERATE(mock::FaultKind::kFlipByte, mock::FaultKind::kDropByte, mock::FaultKind::kLoseOk,
                        mock::FaultKind::kDoubleOk);
  fault.trigger = mock::natural_trigger(fault.kind);
  const bool oks = fault.kind == mock::FaultKind::kLoseOk || fault.kind == mock::FaultKind::kDoubleOk;
  fault.probability = oks ? 0.1 : 2e-3;
  options.faults = {fault};
  if (!oks) {
    fault.outwards = true;
    options.faults.push_back(fault);
  }
  MockBench bench(options);
  REQUIRE(bench.connect());
  std::vector<std::string> file;
  for (int i = 0; i < 5; ++i)
    for (const char* line : {"G28", "G29", "G4 S2", "G1 X10 F1200", "G1 X0"}) file.emplace_back(line);
  bench.print(file);
  REQUIRE(bench.run_until([&] { return bench.over(); }, 7200));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.count<LineDone>() == static_cast<int>(file.size()));
}

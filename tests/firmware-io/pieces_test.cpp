#include "firmware-io/marlin/window.h"
#include "tests/firmware-io/driver_prints.h"

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::fw::marlin;
using namespace voidpath::test;

namespace {

// What was written behind the last newline.
std::string open_line(const std::string& written) { return written.substr(written.rfind('\n') + 1); }

/// A print that stands with a line begun, since the printer is at work on the first ones.
struct Cut {
  DriverBench bench;
  std::string written;

  Cut() {
    REQUIRE(bench.connect());
    REQUIRE(bench.run_until([&] { return bench.firmware.front() == nullptr; }));
    bench.mute = true;
    bench.driver.print(std::make_unique<MemorySource>(moves(40)), bench.t);
    written = bench.driver.output();
    REQUIRE(written.size() == 127);
    REQUIRE(open_line(written).starts_with("N"));
  }
};

}  // namespace

TEST_CASE("a line is begun where it does not fit, and the limit is used to its last byte", "[pieces]") {
  Window window({.max_bytes = 60});
  const std::string payload = "G1 X12.345 Y67.89";
  REQUIRE(window.may_send(payload));
  window.send(payload);
  window.send(payload);
  REQUIRE_FALSE(window.may_begin(payload));
  window.set_piecewise(true);
  REQUIRE_FALSE(window.may_send(payload));
  REQUIRE(window.may_begin(payload));
  const auto whole = static_cast<int>(window.send(payload).size());
  CHECK(window.bytes_in_flight() == 3 * whole);
  CHECK(window.withheld() == 3 * whole - 60);
  CHECK_FALSE(window.may_begin("M105"));
  CHECK(window.let_out() == 0);
  window.on_ok({});
  CHECK(window.let_out() == 3 * whole - 60);
  CHECK(window.withheld() == 0);
  CHECK(window.bytes_in_flight() == 2 * whole);
}

TEST_CASE("a line begun is sent to its end when it is the last in flight or after a stall", "[pieces]") {
  const bool stalled = GENERATE(false, true);
  Window window({.max_bytes = 30});
  window.set_piecewise(true);
  const std::string payload = "G1 X12.345 Y67.89";
  window.send(payload);
  REQUIRE(window.may_begin(payload));
  window.send(payload);
  REQUIRE(window.withheld() > 0);
  if (stalled)
    window.on_stall();
  else
    window.on_ok({});
  CHECK(window.let_out() > 0);
  CHECK(window.withheld() == 0);
  CHECK(window.wants_probe() == false);
}

TEST_CASE("nothing is begun while lines go one at a time", "[pieces]") {
  Window window({.max_bytes = 60});
  window.set_piecewise(true);
  const std::string payload = "G1 X12.345 Y67.89";
  for (int i = 0; i < 3; ++i) window.send(payload);
  REQUIRE(window.withheld() > 0);
  window.on_resend(2);
  CHECK(window.withheld() == 0);
  window.on_quiet();
  CHECK(window.resend().has_value());
  while (window.resending()) {
    window.on_ok({});
    while (window.resend()) {
    }
  }
  REQUIRE(window.throttled());
  CHECK(window.may_begin(payload) == window.may_send(payload));
}

TEST_CASE("moves in pieces arrive whole, once and in order, and never overrun the ring", "[pieces]") {
  DriverBench bench({.queue_lines = 1});
  REQUIRE(bench.connect());
  bench.print(moves(500));
  REQUIRE(bench.run_until([&] { return over(bench); }));
  CHECK(bench.count<PrintFinished>() == 1);
  CHECK(bench.firmware.overflowed == 0);
  CHECK(bench.get<LinkStats>().resends == 0);
}

TEST_CASE("a request ends what is out of a line by a newline, and the line comes whole later", "[pieces]") {
  Cut cut;
  const std::string piece = open_line(cut.written);
  cut.bench.driver.output().clear();
  cut.bench.driver.received("Error:checksum mismatch, Last Line: 4\n", cut.bench.t);
  CHECK(cut.bench.driver.output() == "\n");
  cut.bench.firmware.receive(cut.written);
  cut.bench.mute = false;
  REQUIRE(cut.bench.run_until([&] { return over(cut.bench); }));
  CHECK(cut.bench.count<PrintFinished>() == 1);
  const auto of_number = [&](const std::string& line) { return line.starts_with(piece.substr(0, 5)); };
  const auto again = std::find_if(cut.bench.raw.begin(), cut.bench.raw.end(), of_number);
  REQUIRE(again != cut.bench.raw.end());
  CHECK(again->starts_with(piece));
}

TEST_CASE("what is out of band waits for the end of a line begun; M112 ends it where it is", "[pieces]") {
  Cut cut;
  cut.bench.driver.output().clear();
  const bool halts = GENERATE(false, true);
  if (halts)
    cut.bench.driver.halt("button", cut.bench.t);
  else
    cut.bench.driver.command("M108", cut.bench.t);
  const std::string out = cut.bench.driver.output();
  if (halts) {
    CHECK(out.starts_with("\nM112\nN"));
  } else {
    CHECK(out.ends_with("\nM108\n"));
    const std::string line = open_line(cut.written) + out.substr(0, out.find('\n'));
    CHECK(line.find('*') != line.npos);
  }
}

TEST_CASE("in a silence the line begun is ended before the question", "[pieces]") {
  Cut cut;
  cut.bench.firmware.receive(cut.written);
  cut.bench.driver.output().clear();
  const auto asked = [&] {
    return !cut.bench.raw.empty() && cut.bench.raw.back().find("M105") != std::string::npos;
  };
  REQUIRE(cut.bench.run_until(asked, 5));
  CHECK(cut.bench.firmware.overflowed == 0);
  cut.bench.mute = false;
  REQUIRE(cut.bench.run_until([&] { return over(cut.bench); }));
  CHECK(cut.bench.count<PrintFinished>() == 1);
  CHECK(cut.bench.printed() == moves(40) + Lines{"M400"});
}

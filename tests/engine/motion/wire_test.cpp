#include "engine/motion/wire.h"

#include "tests/engine/motion/recorder.h"

#include <catch2/catch.hpp>

using namespace voidpath::motion;
using voidpath::test::move_to;
using voidpath::test::plain_limits;

namespace {

constexpr std::string_view kCommand = "G1 X100.25 Y20 E.305";

struct Outcome {
  double total;
  double limited;
};
/// `count` lines of `length` mm at 100 mm/s.
Outcome print_lines(double baud, int count, double length) {
  MachineLimits limits = plain_limits();
  limits.baud = baud;
  WiredPlanner planner(limits, nullptr);
  for (int i = 1; i <= count; ++i) {
    planner.receive(kCommand);
    planner.line_to(move_to(i * length, 0, 100));
    planner.confirm();
  }
  planner.finish();
  return {planner.now(), planner.serial_limited()};
}

}  // namespace

TEST_CASE("a framed line counts number, blank, checksum and newline", "[motion]") {
  const auto plain = LineFormat::plain, dense = LineFormat::dense, packed = LineFormat::packed;
  const std::string_view move = "G1 X1.0 Y-2.5 E.3", other = "M204 P1000";
  CHECK(framed_bytes(move, 7, plain) == std::string_view("N7 G1 X1.0 Y-2.5 E.3*34\n").size());
  CHECK(framed_bytes(move, 12345, plain) == std::string_view("N12345 G1 X1.0 Y-2.5 E.3*34\n").size());
  CHECK(framed_bytes(move, 7, dense) == std::string_view("N7G1X1.0Y-2.5E.3*34\n").size());
  CHECK(framed_bytes(other, 7, dense) == framed_bytes(other, 7, plain));
  // "N7 G1X1.0 Y-2.5E.3*34\n": of twenty characters N, Y, - and * take twelve bits, the others four.
  CHECK(framed_bytes(move, 7, packed) == (16 * 4 + 4 * 12) / 8);
  // "N7 M204 P1000*34\n": of 17 N, both blanks, M, P and * take twelve.
  CHECK(framed_bytes(other, 7, packed) == (11 * 4 + 6 * 12 + 7) / 8);
}

TEST_CASE("confirmed lines follow one another at the wire's speed", "[motion]") {
  SerialLine line(10000, 128);  // 1 ms a byte
  for (int i = 1; i <= 50; ++i) {
    CHECK(line.arrival(20) == Approx(0.020 * i));
    line.confirmed(0.020 * i);
  }
}

TEST_CASE("lines in flight never exceed the receive buffer", "[motion]") {
  SerialLine line(10000, 128);
  for (int i = 1; i <= 6; ++i) {  // 6·20 = 120 of 127 bytes
    CHECK(line.arrival(20) == Approx(0.020 * i));
    line.confirmed(i == 1 ? 5.0 : 6.0);
  }
  CHECK(line.arrival(20) == Approx(5.020));  // when the first is confirmed
  line.confirmed(6.0);
  CHECK(line.arrival(20) == Approx(6.020));
  SECTION("a line longer than the buffer goes alone") { CHECK(line.arrival(200) >= 6.2); }
}

TEST_CASE("segments shorter than the wire can feed take the wire's time", "[motion]") {
  // 0.5 mm at 100 mm/s is 5 ms a line; 20 characters, number and frame are 27 to 30 bytes: at 9600 baud
  // about 30 ms.
  const Outcome slow = print_lines(9600, 2000, 0.5);
  double wire_t = 0;
  for (std::size_t i = 1; i <= 2000; ++i)
    wire_t += static_cast<double>(framed_bytes(kCommand, i, LineFormat::plain)) * 10 / 9600;
  CHECK(slow.total == Approx(wire_t).epsilon(0.02));
  const Outcome free = print_lines(0, 2000, 0.5);
  CHECK(free.limited == 0);
  CHECK(slow.limited == Approx(slow.total - free.total).margin(1e-6));
}

TEST_CASE("long lines do not notice the wire", "[motion]") {
  const Outcome wired = print_lines(115200, 500, 5);
  const Outcome free = print_lines(0, 500, 5);
  CHECK(wired.total == Approx(free.total).margin(0.05));  // only the first lines are waited for
  CHECK(wired.limited == Approx(wired.total - free.total).margin(1e-6));
}

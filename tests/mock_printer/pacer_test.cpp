#include "tests/mock_printer/host_for_test.h"
#include "tests/mock_printer/virtual_clock.h"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <unistd.h>

using namespace voidpath::test::mock;

TEST_CASE("a clock at normal speed never stands") {
  Pacer pacer(1, 2);
  pacer.allowance(10, true, true, 0);
  CHECK(pacer.allowance(10.5, true, true, 0) == Approx(0.5));
  CHECK_FALSE(pacer.holding());
}

TEST_CASE("an accelerated clock stands while the printer waits, until the grace is used up") {
  Pacer pacer(60, 2);
  pacer.allowance(0, false, false, 0);
  CHECK(pacer.allowance(0.1, false, false, 0) == Approx(6));
  CHECK(pacer.allowance(0.2, true, false, 0) == 0);
  CHECK(pacer.holding());
  CHECK(pacer.allowance(1.2, true, false, 0) == 0);
  CHECK(pacer.grace_left() == Approx(1));
  // Polls of the host do not refill the grace; a command that carries the print on does.
  CHECK(pacer.allowance(2.3, true, false, 0) == 0);
  CHECK_FALSE(pacer.holding());
  CHECK(pacer.allowance(2.4, true, false, 0) == Approx(6));
  CHECK(pacer.allowance(2.5, true, false, 1) == 0);
  CHECK(pacer.holding());
}

TEST_CASE("as fast as it can means the next event, but a silent host's idle printer keeps a pace") {
  Pacer pacer(0, 0.5);
  CHECK(std::isinf(pacer.allowance(0, false, false, 0)));
  pacer.allowance(1, true, true, 0);
  pacer.allowance(2, true, true, 0);
  CHECK(pacer.allowance(2.1, true, true, 0) == Approx(0.1 * kIdleSpeed));
  CHECK(std::isinf(pacer.allowance(2.2, true, false, 0)));
}

TEST_CASE("the clock file holds its magic and the seconds") {
  const auto path = std::filesystem::temp_directory_path() / ("clock-" + std::to_string(::getpid()));
  {
    ClockFile clock(path.string());
    clock.publish(1234.5);
    std::ifstream file(path, std::ios::binary);
    char bytes[17] = {};
    file.read(bytes, 17);
    REQUIRE(file.gcount() == 16);
    CHECK(std::memcmp(bytes, "VPCLOCK1", 8) == 0);
    double seconds = 0;
    std::memcpy(&seconds, bytes + 8, 8);
    CHECK(seconds == 1234.5);
  }
  std::filesystem::remove(path);
}

namespace {

/// A zigzag with short moves, corners and retractions.
std::vector<std::string> zigzag(int rows) {
  std::vector<std::string> lines{"M83", "G1 X10 Y10 Z0.2 F6000"};
  for (int r = 0; r < rows; ++r) {
    for (int i = 0; i < 20; ++i)
      lines.push_back("G1 X" + fixed(10 + i * 0.7, 3) + " Y" + fixed(10 + r * 0.4 + (i % 2) * 0.3, 3) +
                      " E0.02 F1800");
    lines.push_back("G1 E-0.8 F2100");
    lines.push_back("G1 X10 Y" + fixed(10.4 + r * 0.4, 3) + " F9000");
    lines.push_back("G1 E0.8 F2100");
  }
  lines.push_back("M400");
  return lines;
}

/// Motion seconds when the host keeps up to `window` lines in flight and the clock runs only while the
/// printer does not wait for it.
double motion_with_window(std::size_t window) {
  Rig rig;
  const auto lines = zigzag(30);
  std::size_t sent = 0, done = 0;
  while (done < lines.size()) {
    while (sent < lines.size() && sent - done < window) {
      ++sent;
      rig.printer.feed(numbered(static_cast<std::int64_t>(sent), lines[sent - 1]));
    }
    done += count_of(rig.printer.take_output(), "ok\n");
    if (!rig.printer.waits_for_host()) rig.printer.advance_to(rig.printer.next_event());
    done += count_of(rig.printer.take_output(), "ok\n");
  }
  CHECK(rig.log == lines);
  return rig.printer.statistics().motion_s;
}

}  // namespace

TEST_CASE("the motion takes the same time however many lines the host has in flight") {
  const double one = motion_with_window(1);
  CHECK(one > 5);
  CHECK(motion_with_window(2) == Approx(one).epsilon(1e-9));
  CHECK(motion_with_window(4) == Approx(one).epsilon(1e-9));
}

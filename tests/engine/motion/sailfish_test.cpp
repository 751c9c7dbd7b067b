#include "engine/motion/sailfish.h"

#include "engine/motion/wire.h"

#include <catch2/catch.hpp>

using namespace voidpath::motion;

namespace {

const AxisFloats kJerk{15, 15, 10, 20};

MachineLimits replicator() {
  MachineLimits m;
  m.firmware = Firmware::s3g;
  m.steps_per_mm = {88.888889, 88.888889, 400, 96.2752018703};
  m.max_speed_mm_s = {300, 300, 19.5, 26.667};
  m.max_acceleration_mm_s2 = {1000, 1000, 150, 2000};
  m.print_acceleration_mm_s2 = m.retract_acceleration_mm_s2 = m.travel_acceleration_mm_s2 = 2000;
  m.jerk_mm_s = PerAxis{15, 15, 10, 20};
  m.min_segment_time_us = 0;
  m.rx_bytes = 512;
  return m;
}

/// `count` moves of `length_mm` each, straight on, as asked for at `speed_mm_s`.
double straight(WiredPlanner& planner, int count, double length_mm, float speed_mm_s) {
  for (int i = 1; i <= count; ++i) {
    planner.receive("G1 X1 Y2");
    planner.line_to({{static_cast<float>(i * length_mm), 0, 0, 0}, speed_mm_s, 0});
    planner.confirm();
  }
  planner.finish();
  return planner.now();
}

}  // namespace

TEST_CASE("Sailfish passes a straight joint at full speed and a right angle from its least") {
  AxisFloats before{50, 0, 0, 0};
  CHECK(sailfish::junction_v({50, 0, 0, 0}, 50, kJerk, true, before) == Approx(50));
  CHECK(before[0] == 50);
  // X has to come to a stop: nothing but the least speed will do.
  CHECK(sailfish::junction_v({0, 50, 0, 0}, 50, kJerk, true, before) == Approx(sailfish::kMinPlannerV));
  CHECK(before[1] == 0);
}

TEST_CASE("Sailfish slows a bend until no axis jumps by more than its jerk") {
  // (50, 0) to (40, 30): Y may jump by 15, that is half of its 30.
  AxisFloats before{50, 0, 0, 0};
  CHECK(sailfish::junction_v({40, 30, 0, 0}, 50, kJerk, true, before) == Approx(25));
  CHECK(before[0] == Approx(20));
  // And a slow corner is what the next one starts from: X may go up from 20 to 35.
  CHECK(sailfish::junction_v({50, 0, 0, 0}, 50, kJerk, true, before) == Approx(35));
}

TEST_CASE("Sailfish starts from an empty queue at its least speed, and takes slow corners as they are") {
  AxisFloats before{};
  CHECK(sailfish::junction_v({50, 0, 0, 0}, 50, kJerk, false, before) == Approx(sailfish::kMinPlannerV));
  CHECK(sailfish::junction_v({-8, 0, 0, 0}, 8, kJerk, true, before) == Approx(8));
}

TEST_CASE("short moves cost what a packet, its reply and a turn-round cost") {
  MachineLimits limits = replicator();
  limits.baud = 115200;
  WiredPlanner planner(limits, nullptr);
  // (35 + 4) bytes at 10 bits and 1 ms: 4.385 ms a move. The moves themselves would take less than 2 ms.
  const int count = 4000;
  const double took_s = straight(planner, count, 0.1, 200);
  CHECK(took_s == Approx(count * (390 / 115200.0 + 0.001)).epsilon(0.01));
  CHECK(planner.serial_limited() > took_s / 3);

  limits.baud = 0;
  WiredPlanner free(limits, nullptr);
  CHECK(straight(free, count, 0.1, 200) < took_s / 2);
  CHECK(free.serial_limited() == 0);
}

TEST_CASE("long moves do not notice the wire") {
  MachineLimits limits = replicator();
  limits.baud = 115200;
  WiredPlanner planner(limits, nullptr);
  const double took_s = straight(planner, 200, 1, 50);
  CHECK(took_s == Approx(200 / 50.0).epsilon(0.03));
  CHECK(planner.serial_limited() < 0.05);
}

#include "engine/motion/junction.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

using namespace voidpath::motion;

namespace {

AxisFloats towards(double degrees) {
  const double a = degrees * std::numbers::pi / 180;
  return {static_cast<float>(std::cos(a)), static_cast<float>(std::sin(a)), 0, 0};
}

DeviationParams long_line() {
  DeviationParams params;
  params.accel_a = 1000;
  params.length_d = 50;
  params.deviation_d = 0.02F;
  params.max_accel_a = {5000, 5000, 100, 5000};
  return params;
}

const AxisFloats kJerk = {8, 8, 0.4F, 5};

}  // namespace

TEST_CASE("a right angle is taken at the deviation's speed", "[motion]") {
  // θ between the lines is 90°, s = sin 45° = 0.70711, s/(1-s) = 2.41421: v² = 1000·0.02·2.41421 = 48.284.
  CHECK(junction_deviation_v2(towards(90), towards(0), long_line()) == Approx(48.284).epsilon(1e-4));
}

TEST_CASE("a gentler corner is faster, a sharper one slower", "[motion]") {
  float last = 0;
  for (const double turn : {170.0, 135.0, 90.0, 45.0, 20.0, 5.0}) {
    const float v2 = junction_deviation_v2(towards(turn), towards(0), long_line());
    CHECK(v2 > last);
    last = v2;
  }
}

TEST_CASE("a reversal is taken at the planner's least speed, straight on at any", "[motion]") {
  CHECK(junction_deviation_v2(towards(180), towards(0), long_line()) == Approx(0.0025));
  CHECK(junction_deviation_v2(towards(0), towards(0), long_line()) > 1e6F);
}

TEST_CASE("the slow axis' share limits the corner", "[motion]") {
  // From z to x: the change of direction is (1, -1)/√2 in x and z, so z's 100 mm/s² allow 141.4 along it.
  const AxisFloats z = {0, 0, 1, 0};
  CHECK(junction_deviation_v2(towards(0), z, long_line()) == Approx(141.42 * 0.02 * 2.41421).epsilon(1e-3));
}

TEST_CASE("short chords keep to the speed of the arc they seem to follow", "[motion]") {
  // 0.2 mm chords turning by 0.3 rad each: a·L/θ = 1000·0.2/0.3 = 666.7, while the deviation alone would
  // give s = cos 0.15 = 0.98877, v² = 1000·0.02·88.06 = 1761. The table is up to 0.01 rad off.
  DeviationParams params = long_line();
  params.length_d = 0.2F;
  const AxisFloats turned = towards(0.3 * 180 / std::numbers::pi);
  CHECK(junction_deviation_v2(turned, towards(0), params) == Approx(666.7).epsilon(0.04));
  params.length_d = 1.2F;
  CHECK(junction_deviation_v2(turned, towards(0), params) == Approx(1761).epsilon(0.01));
}

TEST_CASE("a known radius gives the centripetal speed", "[motion]") {
  DeviationParams params = long_line();
  params.radius_d = 10;  // v² = a·r
  CHECK(junction_deviation_v2(towards(6), towards(0), params) == Approx(10000));
}

TEST_CASE("safe speed lets no axis jump by more than its jerk", "[motion]") {
  // x at 60 may jump 8: 60·8/60 = 8 mm/s along x.
  CHECK(safe_speed({60, 0, 0, 0}, 60, kJerk) == Approx(8));
  // Diagonal at 60: 42.43 an axis; 8/42.43 of 60 = 11.31.
  CHECK(safe_speed({42.426F, 42.426F, 0, 0}, 60, kJerk) == Approx(11.314).epsilon(1e-3));
  // z at 5 within the same line: 0.4/5 of 60 = 4.8, whatever the order of axes.
  CHECK(safe_speed({59.79F, 0, 5, 0}, 60, kJerk) == Approx(4.8).epsilon(1e-3));
  CHECK(safe_speed({3, 3, 0, 0}, 4.243F, kJerk) == Approx(4.243));
}

TEST_CASE("a jerk corner allows the sum of both axes' changes", "[motion]") {
  // 40 mm/s x to 40 mm/s y: each axis changes by 40 but may by 8: 40·8/40 = 8. Stopping and starting anew
  // is as fast.
  const JerkState before{{40, 0, 0, 0}, 40, safe_speed({40, 0, 0, 0}, 40, kJerk)};
  const AxisFloats next = {0, 40, 0, 0};
  CHECK(jerk_junction_v(next, 40, safe_speed(next, 40, kJerk), before, kJerk) == Approx(8));
}

TEST_CASE("a jerk corner with a small change is not limited", "[motion]") {
  // Turning 60 mm/s by 5°: Δx = 0.23, Δy = 5.23, both within 8.
  const JerkState before{{60, 0, 0, 0}, 60, 8};
  const AxisFloats next = {59.77F, 5.229F, 0, 0};
  CHECK(jerk_junction_v(next, 60, 8, before, kJerk) == Approx(60));
}

TEST_CASE("an axis that reverses within its jerk may be passed by stopping", "[motion]") {
  // 8 mm/s forth, 8 back: the jump of 8 counts the larger of stopping and starting: allowed at full speed.
  const JerkState before{{8, 0, 0, 0}, 8, 8};
  CHECK(jerk_junction_v({-8, 0, 0, 0}, 8, 8, before, kJerk) == Approx(8));
}

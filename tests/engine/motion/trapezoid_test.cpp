#include "engine/motion/trapezoid.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::motion;

TEST_CASE("a block that only speeds up takes the time of v = a·t", "[motion]") {
  // From rest at 1000 mm/s² over 50 mm: v² = 2·1000·50, v = 316.2 mm/s, t = v/a = 0.3162 s.
  const double end_v = std::sqrt(2 * 1000.0 * 50);
  CHECK(ideal_seconds(50, 0, 1000, end_v, 1000) == Approx(end_v / 1000));
  // A faster exit cannot be reached: the same.
  CHECK(ideal_seconds(50, 0, 1000, 900, 1000) == Approx(end_v / 1000));
}

TEST_CASE("a block at constant speed takes length over speed", "[motion]") {
  CHECK(ideal_seconds(120, 40, 40, 40, 1000) == Approx(3.0));
}

TEST_CASE("a block too short for its speed is a triangle", "[motion]") {
  // Rest to rest over 10 mm at 1000 mm/s²: 5 mm up, 5 mm down. Peak √(2·1000·5) = 100 mm/s, t = 2·100/1000.
  CHECK(ideal_seconds(10, 0, 500, 0, 1000) == Approx(0.2));
}

TEST_CASE("a full trapezoid is ramp, cruise, ramp", "[motion]") {
  // 0 → 100 mm/s at 1000: 0.1 s, 5 mm. 100 → 50: 0.05 s, 75 mm/s mean, 3.75 mm. Cruise 91.25 mm at 100.
  CHECK(ideal_seconds(100, 0, 100, 50, 1000) == Approx(0.1 + 0.9125 + 0.05));
}

TEST_CASE("a block that cannot brake enough brakes all the way", "[motion]") {
  // 100 mm/s, 1 mm, 1000 mm/s²: end speed √(10000 - 2000) = 89.44, mean 94.72 mm/s.
  const double end_v = std::sqrt(8000.0);
  CHECK(ideal_seconds(1, 100, 100, 0, 1000) == Approx(2 / (100 + end_v)));
}

TEST_CASE("the profile is rounded as in the firmware", "[motion]") {
  // Z by 5 mm at 400 steps/mm, 10 mm/s, 100 mm/s² (40000 steps/s²), rest to rest. The least rate is 120, so
  // up: (4000² - 120²)/80000 = 199.82 → 200 steps; down 199.82 → 199 steps, beginning after 2000 - 199.
  Block block;
  block.step_count = 2000;
  block.nominal_rate = 4000;
  block.nominal_v = 10;
  block.accel_steps = 40000;
  const StepProfile p = step_profile(block, 0.05F, 0.05F);
  CHECK(p.initial_rate == 120);
  CHECK(p.final_rate == 120);
  CHECK(p.accelerate_until == 200);
  CHECK(p.decelerate_after == 1801);

  SECTION("without room for the top speed the ramps meet") {
    // 300 steps: (300 + 199.82 - 199.82)/2 = 150.
    block.step_count = 300;
    const StepProfile q = step_profile(block, 0.05F, 0.05F);
    CHECK(q.accelerate_until == 150);
    CHECK(q.decelerate_after == 150);
  }
  SECTION("slower than the least rate: one interval at 120 steps/s, the others nominal") {
    block.nominal_rate = 50;
    block.nominal_v = 0.125F;
    block.step_count = 10;
    const StepProfile q = step_profile(block, 0.05F, 0.05F);
    CHECK(q.initial_rate == 120);
    CHECK(stepped_seconds(q) == Approx(1.0 / 120 + 9.0 / 50));
  }
}

TEST_CASE("a cruising block takes one interval a step", "[motion]") {
  StepProfile p;
  p.steps = p.decelerate_after = 500;
  p.initial_rate = p.nominal_rate = p.final_rate = 2000;
  p.accel_steps = 80000;
  CHECK(stepped_seconds(p) == Approx(0.25));
  CHECK(stepped_seconds_by_loop(p) == Approx(0.25));
}

namespace {

StepProfile random_profile(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  Block block;
  block.step_count = static_cast<std::uint32_t>(6 + std::exp(unit(random) * 9));
  block.nominal_rate = static_cast<std::uint32_t>(200 + unit(random) * 20000);
  block.nominal_v = static_cast<float>(block.nominal_rate) / 80;
  block.accel_steps = static_cast<std::uint32_t>(10000 + unit(random) * 400000);
  const double v = static_cast<double>(block.nominal_v);
  const auto junction = [&] {
    return static_cast<float>(std::min(v, 0.05 + unit(random) * unit(random) * v));
  };
  return step_profile(block, junction(), junction());
}

}  // namespace

TEST_CASE("the closed form agrees with the stepper's loop", "[motion]") {
  std::mt19937 random(7);
  double closed = 0;
  double loop = 0;
  double worst = 0;
  for (int i = 0; i < 20000; ++i) {
    const StepProfile p = random_profile(random);
    const double a = stepped_seconds(p);
    const double b = stepped_seconds_by_loop(p);
    closed += a;
    loop += b;
    worst = std::max(worst, std::abs(a - b) / b);
  }
  // Whole-number rates make single steps near standstill a matter of luck; over a print it averages out.
  CHECK(closed == Approx(loop).epsilon(3e-5));
  CHECK(worst < 0.03);
}

TEST_CASE("deceleration ends early on the stepper", "[motion]") {
  // 100 mm from rest to rest at 60 mm/s, 1000 mm/s², 80 steps/mm: ideally 100/60 + 60/1000 = 1.7267 s. The
  // stepper also starts and ends at 120 steps/s instead of rest; both make it faster, never slower.
  Block block;
  block.length_d = 100;
  block.step_count = 8000;
  block.nominal_rate = 4800;
  block.nominal_v = 60;
  block.accel_a = 1000;
  block.accel_steps = 80000;
  const double ideal = block_seconds(block, 0.05F, 0.05F, Stepping::ideal);
  const double stepped = block_seconds(block, 0.05F, 0.05F, Stepping::marlin_2_0);
  CHECK(ideal == Approx(100.0 / 60 + 0.06).epsilon(1e-3));
  CHECK(stepped < ideal);
  CHECK(stepped > 0.97 * ideal);
  CHECK(block_seconds(block, 0.05F, 0.05F, Stepping::marlin_2_1_3) == Approx(ideal));
}

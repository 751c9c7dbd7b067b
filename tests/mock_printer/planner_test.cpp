#include "tests/mock_printer/motion.h"

#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

namespace {

/// Seconds from the first block to the end of the last, the queue kept as full as it can be.
double seconds_for(const std::vector<Axes>& targets, double feed, const MotionSettings& settings = {}) {
  Motion motion(settings, 16);
  double now = 0;
  for (const Axes& target : targets) {
    while (motion.full()) {
      now = motion.next_event();
      motion.update(now);
    }
    motion.add_move(now, target, feed, 1);
    motion.update(now);
  }
  while (!motion.drained()) {
    now = motion.next_event();
    motion.update(now);
  }
  return motion.last_end() - motion.first_start();
}

/// Takes blocks out until the n-th (from 0).
Block nth_block(Planner& planner, int n) {
  const Block* block = planner.take();
  while (n-- > 0) {
    planner.release();
    block = planner.take();
  }
  REQUIRE(block != nullptr);
  return *block;
}

}  // namespace

TEST_CASE("a block at one rate takes a step an interval") {
  Block block;
  block.step_events = 1000;
  block.initial_rate = block.nominal_rate = block.final_rate = 2000;
  block.acceleration_rate = 80000;
  block.accelerate_until = 0;
  block.decelerate_after = 1000;
  CHECK(stepping_seconds(block) == Approx(0.5).epsilon(1e-12));
}

TEST_CASE("a long travel takes length over speed plus one ramp") {
  // 100 mm at 50 mm/s, 1500 mm/s²: 100/50 + 50/1500 = 2.0333 s. Starting at 120 steps/s (1.5 mm/s) and the
  // early end of the deceleration take some ms off.
  const double t = seconds_for({{100, 0, 0, 0}}, 50);
  CHECK(t == Approx(2.0333).epsilon(0.005));
  CHECK(t < 2.0333);
}

TEST_CASE("a move too short for its speed is two ramps") {
  // 1 mm at 1500 mm/s²: 2·sqrt(1/1500) = 51.6 ms from rest to rest.
  // Of its 80 steps the first alone takes 8 ms, and braking ends early: the firmware is up to a fifth faster.
  const double t = seconds_for({{1, 0, 0, 0}}, 200);
  CHECK(t < 0.0516);
  CHECK(t > 0.8 * 0.0516);
}

TEST_CASE("each axis keeps its own speed and acceleration") {
  MotionSettings s;
  Planner z(s);
  REQUIRE(z.add_move({0, 0, 10, 0}, 100));
  const Block up = nth_block(z, 0);
  CHECK(up.nominal_speed == Approx(10));
  CHECK(up.acceleration == Approx(100));
  // 3-4-5 in X and Z: Z's 10 mm/s at 0.8 of the way makes 12.5, its 100 mm/s² makes 125.
  Planner slanted(s);
  REQUIRE(slanted.add_move({3, 0, 4, 0}, 100));
  const Block both = nth_block(slanted, 0);
  CHECK(both.nominal_speed == Approx(12.5));
  CHECK(both.acceleration == Approx(125).epsilon(1e-3));
}

TEST_CASE("printing, travelling and retracting have their accelerations") {
  MotionSettings s;
  s.travel_acceleration = 1200;
  Planner p(s);
  p.add_move({50, 0, 0, 1}, 50);
  p.add_move({90, 0, 0, 1}, 50);
  p.add_move({90, 0, 0, 0}, 50);
  CHECK(nth_block(p, 0).acceleration == Approx(1000).epsilon(1e-3));
  p.release();
  CHECK(nth_block(p, 0).acceleration == Approx(1200).epsilon(1e-3));
  p.release();
  const Block retract = nth_block(p, 0);
  CHECK(retract.acceleration == Approx(1500).epsilon(1e-3));
  CHECK(retract.length == Approx(1));
}

TEST_CASE("a right angle is passed at the junction-deviation speed") {
  // s = sin 45°; v² = 1000 · 0.013 · s/(1−s) = 31.38: 5.602 mm/s (1500 along both axes allow 2121
  // diagonally).
  MotionSettings s;
  s.travel_acceleration = 1000;
  Planner p(s);
  p.add_move({20, 0, 0, 0}, 50);
  p.add_move({20, 20, 0, 0}, 50);
  CHECK(std::sqrt(nth_block(p, 1).entry_speed2) == Approx(5.602).epsilon(1e-3));
}

TEST_CASE("a straight line is passed at full speed, a reversal at the least") {
  Planner p{MotionSettings{}};
  p.add_move({20, 0, 0, 0}, 50);
  p.add_move({40, 0, 0, 0}, 50);
  p.add_move({20, 0, 0, 0}, 50);
  CHECK(std::sqrt(nth_block(p, 1).entry_speed2) == Approx(50));
  p.release();
  CHECK(std::sqrt(nth_block(p, 0).entry_speed2) == Approx(kMinimumPlannerSpeed));
}

TEST_CASE("classic jerk bounds the change of each axis at a corner") {
  MotionSettings s;
  s.classic_jerk = true;
  Planner p(s);
  p.add_move({20, 0, 0, 0}, 50);
  p.add_move({20, 20, 0, 0}, 50);
  // X may drop by 8 and Y start with 8.
  CHECK(std::sqrt(nth_block(p, 1).entry_speed2) == Approx(8));
  Planner gentle(s);
  gentle.add_move({20, 0, 0, 0}, 50);
  // 50 (1, 0) to 50 (0.995, 0.0998): Y changes by 4.99, below 8: nothing to slow down for.
  gentle.add_move({20 + 19.9, 1.996, 0, 0}, 50);
  CHECK(std::sqrt(nth_block(gentle, 1).entry_speed2) == Approx(50).epsilon(1e-3));
}

TEST_CASE("fewer than six steps are not queued but joined to the next move") {
  Planner p{MotionSettings{}};
  CHECK_FALSE(p.add_move({0.06, 0, 0, 0}, 50));  // 4.8: five steps
  CHECK(p.empty());
  CHECK(p.add_move({0.12, 0, 0, 0}, 50));
  CHECK(nth_block(p, 0).step_events == 10);
}

TEST_CASE("a draining queue stretches short blocks") {
  // 1 mm at 100 mm/s is 10 ms; with two blocks waiting, 10 + 2·(20−10)/2 = 20 ms: 50 mm/s.
  Planner p{MotionSettings{}};
  for (int i = 1; i <= 3; ++i) p.add_move({i * 1.0, 0, 0, 0}, 100);
  CHECK(nth_block(p, 0).nominal_speed == Approx(100));
  p.release();
  CHECK(nth_block(p, 0).nominal_speed == Approx(100));
  p.release();
  CHECK(nth_block(p, 0).nominal_speed == Approx(50));
}

TEST_CASE("fifteen blocks fill the ring of sixteen; what runs is not replanned") {
  Planner p{MotionSettings{}};
  for (int i = 1; i <= 15; ++i) {
    REQUIRE_FALSE(p.full());
    p.add_move({i * 1.0, 0, 0, 0}, 50);
  }
  CHECK(p.full());
  CHECK(p.free() == 0);
  p.take();
  CHECK(p.full());  // what runs keeps its place
  p.release();
  const Block* running = p.take();
  const auto until = running->decelerate_after;
  p.add_move({100, 0, 0, 0}, 50);
  CHECK(running == p.busy());
  CHECK(running->decelerate_after == until);
}

TEST_CASE("splitting a line never makes it faster") {
  const double whole = seconds_for({{60, 0, 0, 0}}, 100);
  for (const int parts : {2, 10, 60, 300}) {
    std::vector<Axes> targets;
    for (int i = 1; i <= parts; ++i) targets.push_back({60.0 * i / parts, 0, 0, 0});
    const double split = seconds_for(targets, 100);
    CAPTURE(parts, whole, split);
    // Rounding to whole steps and rates may win 0.5 %.
    CHECK(split > whole * 0.995);
  }
}

TEST_CASE("motion waits a moment for a third block, no longer") {
  Motion motion(MotionSettings{}, 16);
  motion.add_move(1.0, {10, 0, 0, 0}, 50, 1);
  motion.update(1.0);
  CHECK(motion.first_start() < 0);
  CHECK(motion.next_event() == Approx(1.1));
  motion.add_move(1.01, {20, 0, 0, 0}, 50, 1);
  motion.update(1.01);
  CHECK(motion.first_start() < 0);
  motion.add_move(1.02, {30, 0, 0, 0}, 50, 1);
  motion.update(1.02);
  CHECK(motion.first_start() == Approx(1.02));
}

TEST_CASE("a stop leaves the machine where it is") {
  Motion motion(MotionSettings{}, 16);
  motion.add_move(0, {100, 0, 0, 0}, 50, 1);
  motion.update(0.1);
  motion.quick_stop(1.1);
  CHECK(motion.drained());
  const Axes position = motion.planner().position();
  CHECK(position[kX] > 40);
  CHECK(position[kX] < 60);
  CHECK(motion.moving_seconds() == Approx(1.0));
}

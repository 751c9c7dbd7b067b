#include "engine/motion/planner.h"

#include "tests/engine/motion/recorder.h"

#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::motion;
using voidpath::test::move_to;
using voidpath::test::plain_limits;
using voidpath::test::Recorder;

namespace {

using Path = std::vector<Move>;  // the first is where it starts

Recorder run(const MachineLimits& limits, const Path& path) {
  Recorder recorder;
  Planner planner(limits, &recorder);
  planner.reset_position(path.front().target_d);
  for (std::size_t i = 1; i < path.size(); ++i) planner.line_to(path[i]);
  planner.finish();
  return recorder;
}

/// Lines of 1 to 9 mm (long enough not to count as chords of arcs) at 20 to 120 mm/s.
Path wander(unsigned seed, int count) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  Path path = {move_to(100, 100, 60)};
  double x = 100;
  double y = 100;
  for (int i = 0; i < count; ++i) {
    const double length = 1 + 8 * unit(random);
    const double angle = 6.2832 * unit(random);
    x += length * std::cos(angle);
    y += length * std::sin(angle);
    path.push_back(move_to(x, y, 20 + 100 * unit(random)));
  }
  return path;
}

/// The same lines from end to start.
Path backwards(const Path& path) {
  Path out = {path.back()};
  for (std::size_t i = path.size() - 1; i > 0; --i) {
    out.push_back(path[i - 1]);
    out.back().feed_v = path[i].feed_v;
  }
  return out;
}

/// Every line cut into `parts` pieces.
Path split(const Path& path, int parts) {
  Path out = {path.front()};
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (int k = 1; k <= parts; ++k) {
      Move piece = path[i];
      for (std::size_t axis = 0; axis < 4; ++axis) {
        const float from = path[i - 1].target_d[axis];
        piece.target_d[axis] =
            from + (path[i].target_d[axis] - from) * static_cast<float>(k) / static_cast<float>(parts);
      }
      out.push_back(piece);
    }
  }
  return out;
}

}  // namespace

TEST_CASE("one line from rest to rest takes the time of its trapezoid", "[motion]") {
  // 100 mm at 50 mm/s, 1000 mm/s²: 100/50 + 50/1000 = 2.05 s (0.05 mm/s instead of rest is nothing).
  const Recorder out = run(plain_limits(), {move_to(0, 0, 50), move_to(100, 0, 50)});
  REQUIRE(out.entries.size() == 1);
  CHECK(out.busy_t() == Approx(2.05).epsilon(1e-3));
  // It waited 100 polls of 1 ms for company.
  CHECK(out.entries[0].start_t == Approx(0.1).margin(0.0011));
}

TEST_CASE("three lines start at the next poll", "[motion]") {
  const Recorder out =
      run(plain_limits(), {move_to(0, 0, 50), move_to(10, 0, 50), move_to(20, 0, 50), move_to(30, 0, 50)});
  REQUIRE(out.entries.size() == 3);
  CHECK(out.entries[0].start_t <= 0.0011);
}

TEST_CASE("a right angle is passed at the junction speed from both sides", "[motion]") {
  const Recorder out = run(plain_limits(), {move_to(0, 0, 50), move_to(50, 0, 50), move_to(50, 50, 50)});
  REQUIRE(out.entries.size() == 2);
  // v² = 1000·0.02·2.41421 = 48.28, v = 6.949. One side: (50 - 0)/1000 + (50 - 6.949)/1000 of ramps covering
  // 1.25 + 1.226 mm, the rest at 50: 0.05 + 0.04305 + 47.524/50 = 1.0435 s.
  CHECK(out.entries[0].exit_v == Approx(6.949).epsilon(1e-3));
  CHECK(out.entries[1].entry_v == out.entries[0].exit_v);
  CHECK(out.entries[0].duration_t == Approx(1.0435).epsilon(1e-3));
  CHECK(out.entries[1].duration_t == Approx(1.0435).epsilon(1e-3));
}

TEST_CASE("no block is faster than its speed, no corner than its limit", "[motion]") {
  MachineLimits limits = plain_limits();
  if (GENERATE(false, true)) limits.jerk_mm_s = PerAxis{8, 8, 0.4, 5};
  const Recorder out = run(limits, wander(3, 500));
  REQUIRE(out.entries.size() == 500);
  for (std::size_t i = 0; i < out.entries.size(); ++i) {
    const auto& entry = out.entries[i];
    const auto length = static_cast<double>(entry.block.length_d);
    const auto nominal = static_cast<double>(entry.block.nominal_v);
    CHECK(entry.duration_t >= length / nominal * (1 - 1e-6));
    CHECK(entry.entry_v <= nominal * (1 + 1e-6));
    CHECK(entry.entry_v * entry.entry_v <=
          std::max(0.0026, static_cast<double>(entry.block.max_entry_v2) * (1 + 1e-5)));
    // Within what its acceleration can do.
    const double change = std::abs(entry.exit_v * entry.exit_v - entry.entry_v * entry.entry_v);
    CHECK(change <= 2 * static_cast<double>(entry.block.accel_a) * length * (1 + 1e-3) + 0.01);
    if (i > 0) CHECK(out.entries[i - 1].exit_v == entry.entry_v);
  }
}

TEST_CASE("with deep look-ahead the reversed path takes the same time", "[motion]") {
  MachineLimits limits = plain_limits();
  limits.block_buffer = 1024;
  limits.min_segment_time_us = 0;
  const Path path = wander(GENERATE(1U, 2U, 3U), 400);
  CHECK(run(limits, path).busy_t() == Approx(run(limits, backwards(path)).busy_t()).epsilon(1e-4));
}

TEST_CASE("with deep look-ahead splitting changes nothing", "[motion]") {
  MachineLimits limits = plain_limits();
  limits.block_buffer = 1024;
  limits.min_segment_time_us = 0;
  // 1 mm at least after splitting, so that no piece counts as a chord.
  const Path path = {move_to(0, 0, 100), move_to(60, 0, 100), move_to(60, 40, 80), move_to(20, 10, 120)};
  const double whole = run(limits, path).busy_t();
  CHECK(run(limits, split(path, 20)).busy_t() == Approx(whole).epsilon(5e-4));
}

TEST_CASE("with the firmware's buffer splitting never makes it faster", "[motion]") {
  MachineLimits limits = plain_limits();
  limits.print_acceleration_mm_s2 = limits.travel_acceleration_mm_s2 = 200;
  limits.min_segment_time_us = 0;
  const Path path = {move_to(0, 0, 100), move_to(60, 0, 100), move_to(60, 40, 80), move_to(20, 10, 120)};
  double last = run(limits, path).busy_t() * (1 - 1e-3);
  // Fifteen blocks of 20 mm see far enough; of 0.75 mm they do not: 100 mm/s needs 25 mm to stop.
  for (const int parts : {2, 8, 20, 80}) {
    const double now = run(limits, split(path, parts)).busy_t();
    CHECK(now >= last * (1 - 5e-4));
    last = now;
  }
  CHECK(last > 1.02 * run(limits, path).busy_t());
}

TEST_CASE("a dwell is a full stop of its length", "[motion]") {
  Recorder recorder;
  Planner planner(plain_limits(), &recorder);
  planner.line_to(move_to(50, 0, 50));
  planner.dwell(2.5);
  planner.line_to(move_to(100, 0, 50));
  planner.finish();
  REQUIRE(recorder.entries.size() == 2);
  CHECK(recorder.entries[0].exit_v == Approx(0.05));
  CHECK(recorder.entries[1].entry_v == Approx(0.05));
  // Each 50/50 + 50/1000 = 1.05 s, each after up to 100 ms of waiting for company.
  CHECK(planner.now() == Approx(2 * 1.05 + 2.5 + 2 * 0.1).margin(0.005));
}

TEST_CASE("a line below six steps is left to the next", "[motion]") {
  MachineLimits limits = plain_limits();
  limits.steps_per_mm = {80, 80, 400, 93};
  Recorder recorder;
  Planner planner(limits, &recorder);
  CHECK_FALSE(planner.line_to(move_to(0.06, 0, 10)));  // 4.8 → 5 steps
  CHECK(planner.line_to(move_to(0.12, 0, 10)));        // 9.6 → 10 steps from where the last block ended
  planner.finish();
  REQUIRE(recorder.entries.size() == 1);
  CHECK(recorder.entries[0].block.length_d == Approx(0.125));
}

TEST_CASE("acceleration goes by the kind of move and by axis", "[motion]") {
  MachineLimits limits = plain_limits();
  limits.print_acceleration_mm_s2 = 600;
  limits.travel_acceleration_mm_s2 = 800;
  limits.retract_acceleration_mm_s2 = 900;
  limits.max_acceleration_mm_s2 = {1000, 1000, 50, 2000};
  const Recorder out =
      run(limits, {move_to(0, 0, 20), move_to(50, 0, 20), move_to(60, 0, 20, 1), move_to(60, 0, 20, 0),
                   move_to(60, 0, 20, 0, 5), move_to(63, 0, 20, 0, 9)});
  REQUIRE(out.entries.size() == 5);
  CHECK(out.entries[0].block.accel_a == Approx(800));
  CHECK(out.entries[0].block.kind == MoveKind::travel);
  CHECK(out.entries[1].block.accel_a == Approx(600));
  CHECK(out.entries[1].block.kind == MoveKind::extrude);
  CHECK(out.entries[2].block.accel_a == Approx(900));
  CHECK(out.entries[2].block.kind == MoveKind::filament);
  CHECK(out.entries[3].block.accel_a == Approx(50));
  CHECK(out.entries[4].block.accel_a == Approx(50 / 0.8));  // z has 4/5 of it
}

TEST_CASE("speed goes down until no axis exceeds its own", "[motion]") {
  MachineLimits limits = plain_limits();
  limits.max_speed_mm_s = {500, 500, 10, 60};
  const Recorder out = run(limits, {move_to(0, 0, 100), move_to(3, 0, 100, 0, 4), move_to(3, 0, 100, 5, 4)});
  REQUIRE(out.entries.size() == 2);
  CHECK(out.entries[0].block.nominal_v == Approx(12.5));  // z has 4/5 of it
  CHECK(out.entries[1].block.nominal_v == Approx(60));
}

TEST_CASE("short lines are stretched while the buffer fills from empty", "[motion]") {
  // 1 mm at 100 mm/s is 10 ms, 10 short of the 20. With n blocks waiting 2·10/n ms are added: for n = 2 it
  // takes 20 ms, for n = 4 15 ms, for n = 7 12.857 ms. From n = 8 on nothing.
  Path path = {move_to(0, 0, 100)};
  for (int i = 1; i <= 12; ++i) path.push_back(move_to(i, 0, 100));
  const Recorder out = run(plain_limits(), path);
  REQUIRE(out.entries.size() == 12);
  const auto nominal = [&](std::size_t i) { return static_cast<double>(out.entries[i].block.nominal_v); };
  CHECK(nominal(1) == Approx(100));
  CHECK(nominal(2) == Approx(50));
  CHECK(nominal(4) == Approx(1 / 0.015));
  CHECK(nominal(7) == Approx(1 / 0.012857).epsilon(1e-4));
  CHECK(nominal(8) == Approx(100));
}

TEST_CASE("a renamed position moves nothing and does not stop", "[motion]") {
  Recorder recorder;
  Planner planner(plain_limits(), &recorder);
  for (int i = 1; i <= 3; ++i) planner.line_to(move_to(10 * i, 0, 50, i));
  planner.set_position(Axis::e, 0);
  planner.line_to(move_to(40, 0, 50, 1));
  planner.finish();
  REQUIRE(recorder.entries.size() == 4);
  CHECK(recorder.entries[3].block.e_d == Approx(1));
  CHECK(recorder.entries[3].entry_v == Approx(50));
}

TEST_CASE("flow scales the filament and with it the line's kind", "[motion]") {
  Recorder recorder;
  Planner planner(plain_limits(), &recorder);
  planner.set_flow(0.5F);
  planner.line_to(move_to(10, 0, 50, 2));
  planner.set_flow(0);
  planner.line_to(move_to(20, 0, 50, 4));
  planner.finish();
  REQUIRE(recorder.entries.size() == 2);
  CHECK(recorder.entries[0].block.e_d == Approx(1));
  CHECK(recorder.entries[1].block.kind == MoveKind::travel);
}

TEST_CASE("changed limits hold for later lines only", "[motion]") {
  Recorder recorder;
  Planner planner(plain_limits(), &recorder);
  planner.line_to(move_to(10, 0, 50));
  MachineLimits limits = planner.limits();
  limits.travel_acceleration_mm_s2 = 300;
  limits.max_speed_mm_s[0] = -5;  // nonsense keeps the old
  planner.set_limits(limits);
  planner.line_to(move_to(20, 0, 50));
  planner.finish();
  REQUIRE(recorder.entries.size() == 2);
  CHECK(recorder.entries[0].block.accel_a == Approx(1000));
  CHECK(recorder.entries[1].block.accel_a == Approx(300));
  CHECK(recorder.entries[1].block.nominal_v == Approx(50));
}

TEST_CASE("blocks come back in order with their tags, one after the other", "[motion]") {
  Path path = wander(5, 100);
  for (std::size_t i = 0; i < path.size(); ++i) path[i].tag = i;
  const Recorder out = run(MachineLimits{}, path);
  REQUIRE(out.entries.size() == 100);
  for (std::size_t i = 0; i < 100; ++i) {
    CHECK(out.entries[i].block.tag == i + 1);
    if (i > 0)
      CHECK(out.entries[i].start_t == Approx(out.entries[i - 1].start_t + out.entries[i - 1].duration_t));
  }
}

TEST_CASE("a copy plans on independently", "[motion]") {
  Planner planner(MachineLimits{});
  planner.line_to(move_to(10, 0, 50));
  Planner copy = planner;
  copy.line_to(move_to(60, 0, 50));
  copy.finish();
  planner.finish();
  CHECK(copy.now() > planner.now() + 0.9);
}

TEST_CASE("nonsense is clamped", "[motion]") {
  MachineLimits limits;
  limits.block_buffer = -3;
  limits.steps_per_mm[2] = 0;
  Planner planner(limits);
  const float nan = std::nanf("");
  planner.line_to({{nan, 1e30F, -1e30F, nan}, nan, 0});
  planner.line_to({{0, 0, 0, 0}, -1, 0});
  planner.line_to({{1, 2, 3, 4}, 1e30F, 0});
  planner.finish();
  CHECK(std::isfinite(planner.now()));
}

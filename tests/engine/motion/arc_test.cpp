#include "engine/motion/arc.h"

#include "tests/engine/motion/recorder.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::motion;
using voidpath::test::plain_limits;
using voidpath::test::Recorder;

namespace {

struct Cut {
  std::vector<Move> moves;
  std::vector<Chord> chords;
  double length_d = 0;
};

Cut cut(const Arc& arc) {
  Cut out;
  AxisFloats at = arc.from_d;
  cut_arc(arc, plain_limits(), [&](const Move& move, const Chord& chord) {
    out.moves.push_back(move);
    out.chords.push_back(chord);
    out.length_d += std::hypot(static_cast<double>(move.target_d[0] - at[0]),
                               static_cast<double>(move.target_d[1] - at[1]));
    at = move.target_d;
  });
  return out;
}

Arc quarter(bool clockwise) {
  Arc arc;  // centre at the origin, from (10, 0)
  arc.from_d = {10, 0, 0, 0};
  arc.to_d = {0, clockwise ? -10.0F : 10.0F, 1, 2};
  arc.center_x_d = -10;
  arc.clockwise = clockwise;
  arc.feed_v = 30;
  return arc;
}

}  // namespace

TEST_CASE("a quarter circle becomes chords of at most 1 mm on the circle", "[motion]") {
  // r = 10: 15.708 mm, 15 whole millimetres but 72/4 = 18 chords a quarter at least.
  const bool clockwise = GENERATE(true, false);
  const Cut out = cut(quarter(clockwise));
  REQUIRE(out.moves.size() == 18);
  CHECK(out.length_d == Approx(15.708).epsilon(2e-3));
  for (const Move& move : out.moves) {
    CHECK(std::hypot(move.target_d[0], move.target_d[1]) == Approx(10).margin(1e-4));
    CHECK((clockwise ? move.target_d[1] <= 0 : move.target_d[1] >= 0));
  }
  CHECK(out.moves[8].target_d[2] == Approx(0.5));  // z and e in proportion
  CHECK(out.moves[8].target_d[3] == Approx(1.0));
  CHECK(out.moves.back().target_d == quarter(clockwise).to_d);
}

TEST_CASE("the other way round is the three-quarter circle", "[motion]") {
  Arc arc = quarter(false);
  arc.clockwise = true;
  CHECK(cut(arc).length_d == Approx(1.5 * std::numbers::pi * 10).epsilon(2e-3));
}

TEST_CASE("an arc that ends where it began is a full turn, P adds more", "[motion]") {
  Arc arc = quarter(false);
  arc.to_d = arc.from_d;
  CHECK(cut(arc).length_d == Approx(2 * std::numbers::pi * 10).epsilon(2e-3));
  arc.extra_turns = 2;
  CHECK(cut(arc).length_d == Approx(6 * std::numbers::pi * 10).epsilon(2e-3));
}

TEST_CASE("a tiny circle gets no chords below 0.1 mm", "[motion]") {
  Arc arc;  // r = 0.5: 3.14 mm; 72 chords would be 0.044 mm: 31 instead
  arc.center_x_d = 0.5F;
  arc.feed_v = 10;
  CHECK(cut(arc).moves.size() == 31);
}

TEST_CASE("an arc may stop safely only as fast as its rest allows", "[motion]") {
  const Cut out = cut(quarter(true));
  CHECK(out.chords.front().radius_d == 0);
  CHECK(out.chords[1].radius_d == Approx(10));
  CHECK(out.chords.back().safe_exit_v2 == 0);
  // a·r = 1000·10 and 30² = 900: the feed is the limit until 2·a·rest falls below it.
  CHECK(out.chords[2].safe_exit_v2 == Approx(900));
}

TEST_CASE("the centre of a radius arc lies on the side of the shorter way", "[motion]") {
  const AxisFloats from = {10, 0, 0, 0};
  const AxisFloats to = {0, 10, 0, 0};
  const auto ccw = arc_center(from, to, 10, false);
  REQUIRE(ccw);
  CHECK(ccw->first == Approx(-10));
  CHECK(ccw->second == Approx(0).margin(1e-5));
  const auto cw = arc_center(from, to, 10, true);  // the other side: centre (10, 10)
  REQUIRE(cw);
  CHECK(cw->first == Approx(0).margin(1e-5));
  CHECK(cw->second == Approx(10));
  CHECK(arc_center(from, to, -10, true)->first == Approx(-10));
  CHECK_FALSE(arc_center(from, from, 10, true));
}

TEST_CASE("an arc takes the time of its length once up to speed", "[motion]") {
  Recorder recorder;
  Planner planner(plain_limits(), &recorder);
  planner.reset_position({10, 0, 0, 0});
  Arc arc = quarter(false);
  arc.to_d = {10, 0, 0, 0};
  cut_arc(arc, planner.limits(), [&](const Move& m, const Chord& c) { planner.chord_to(m, c); });
  planner.finish();
  // 62.8 mm at 30 mm/s, √(a·r) = 100 mm/s allows it; both ramps cost 30/1000/2 s each. The first corner is
  // not yet known to be an arc's and may cost a little more.
  CHECK(recorder.busy_t() == Approx(62.8 / 30 + 0.03).epsilon(0.01));
}

TEST_CASE("a tight arc goes as fast as its curvature allows, and takes the time for it", "[motion]") {
  Recorder recorder;
  Planner planner(plain_limits(), &recorder);
  planner.reset_position({2, 0, 0, 0});
  Arc arc;
  arc.from_d = {2, 0, 0, 0};
  arc.to_d = arc.from_d;
  arc.center_x_d = -2;
  arc.extra_turns = 9;
  arc.feed_v = 200;
  cut_arc(arc, planner.limits(), [&](const Move& m, const Chord& c) { planner.chord_to(m, c); });
  planner.finish();
  // Ten turns of r = 2, the way along their chords: 125.6 mm, at √(a·r) = √(1000·2) = 44.72 mm/s. Both ramps
  // cost 44.72/1000/2 s each.
  const double cruise_v = std::sqrt(1000.0 * 2);
  CHECK(recorder.busy_t() == Approx(125.6 / cruise_v + cruise_v / 1000).epsilon(0.01));
}

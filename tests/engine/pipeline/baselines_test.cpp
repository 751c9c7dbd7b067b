#include "engine/pipeline/baselines.h"

#include "engine/pipeline/next_candidates.h"
#include "tests/support/meshes.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using geom::Vec3;
using pipeline::Underside;

TEST_CASE("what touches and what hangs over, in closed form") {
  // A plate of 60 x 40 on four legs of 5 x 5.
  const auto table = test::table(60, 40, 30, 3, 5);
  const auto under = pipeline::undersides(table, {Vec3::UnitZ(), -Vec3::UnitZ(), Vec3::UnitX()}, {}, {});
  CHECK(under[0].contact_mm2 == Approx(4 * 25));
  CHECK(under[0].overhang_mm2 == Approx(60 * 40 - 4 * 25));
  CHECK(under[1].contact_mm2 == Approx(60 * 40));  // upside down the legs stand up
  CHECK(under[1].overhang_mm2 == Approx(0).margin(1e-9));
  // On its side: the plate's edge and two legs lie down, the inner sides of the two others hang over.
  CHECK(under[2].contact_mm2 == Approx(3 * 40 + 2 * 5 * 27));
  CHECK(under[2].overhang_mm2 == Approx(2 * 5 * 27));
}

TEST_CASE("only what leans out further than the limit hangs over") {
  const auto cube = test::cube(10);
  const Vec3 edge = Vec3(1, 0, 1).normalized();  // both lower faces lean out 45°
  pipeline::UndersideOptions options;
  options.overhang_deg = 45;
  CHECK(pipeline::undersides(cube, {edge}, options, {})[0].overhang_mm2 == 0);
  options.overhang_deg = 44;
  CHECK(pipeline::undersides(cube, {edge}, options, {})[0].overhang_mm2 == Approx(2 * 100 * std::sqrt(0.5)));
  CHECK(pipeline::undersides(cube, {edge}, options, {})[0].contact_mm2 == 0);
}

TEST_CASE("less overhang and more contact are less unprintable") {
  const double surface = 1000;
  const double base = pipeline::unprintability({100, 50}, surface);
  CHECK(pipeline::unprintability({100, 40}, surface) < base);
  CHECK(pipeline::unprintability({110, 50}, surface) < base);
  CHECK(std::isfinite(pipeline::unprintability({0, 0}, surface)));
  CHECK(pipeline::unprintability({50, 0}, surface) > pipeline::unprintability({60, 0}, surface));
}

TEST_CASE("a table is turned upside down by least overhang, laid flat by least height") {
  const auto table = test::table(60, 40, 30, 3, 5);
  pipeline::PrepareOptions options;
  options.orient.subdivisions = 1;
  const orient::Choice choice = orient::search(table, options.orient);
  const auto under = pipeline::undersides_of(table, choice, options, {});
  REQUIRE(under.size() == choice.candidates.size());
  const auto best = pipeline::least_overhang(choice, under, mesh::surface_area(table));
  REQUIRE(best);
  CHECK(choice.candidates[*best].direction == -Vec3::UnitZ());
  const auto low = pipeline::lowest(choice);
  REQUIRE(low);
  CHECK(choice.candidates[*low].direction == -Vec3::UnitZ());  // as low as upright, but nothing trapped
}

TEST_CASE("of equals the part stays as it came") {
  const auto cube = test::cube(10);
  pipeline::PrepareOptions options;
  options.orient.subdivisions = 0;
  const orient::Choice choice = orient::search(cube, options.orient);
  CHECK(pipeline::lowest(choice) == choice.as_delivered);
  const auto under = pipeline::undersides_of(cube, choice, options, {});
  CHECK(pipeline::least_overhang(choice, under, mesh::surface_area(cube)) == choice.as_delivered);
  CHECK(pipeline::score_winner(choice, orient::kThesisWeights, pipeline::Only::printable, 1e-9) ==
        choice.as_delivered);
}

TEST_CASE("nothing is the lowest of nothing") {
  orient::Choice choice;
  choice.candidates.resize(1);
  choice.candidates[0].printable = false;
  CHECK_FALSE(pipeline::lowest(choice));
  CHECK_FALSE(pipeline::score_winner(choice, orient::kThesisWeights, pipeline::Only::printable, 1e-9));
  CHECK(pipeline::score_winner(choice, orient::kThesisWeights, pipeline::Only::any, 1e-9) == 0U);
}

TEST_CASE("next candidates: printable, new, unlike, and the promising first") {
  orient::SearchOptions options;
  options.subdivisions = 2;
  options.limits.min_contact_mm2 = 0;  // an egg may stand anywhere
  options.limits.stability_margin_mm = -1e3;
  auto egg = test::sphere(15, 7, 12);
  for (auto& v : egg.vertices) v = v.cwiseProduct(geom::Vec3(1, 1.3, 1.9));
  orient::Choice choice = orient::search(egg, options);
  const auto under = pipeline::undersides_of(egg, choice, {}, {});
  // Time is height, but for one thing: what hangs over costs.
  const auto pretend = [&](std::size_t i) {
    return 100 * std::exp(choice.candidates[i].criteria.height_mm / 60 + under[i].overhang_mm2 / 1000);
  };
  std::size_t fastest = choice.chosen;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i)
    if (choice.candidates[i].printable && pretend(i) < pretend(fastest)) fastest = i;
  const pipeline::NextCandidates queue(choice, under,
                                       [&](std::size_t i) { return choice.candidates[i].predicted_s; });
  std::size_t timed = 0;
  for (;;) {
    const auto wave = queue.next(4);
    if (wave.empty()) break;
    CHECK(wave.size() <= 4);
    for (const std::size_t i : wave) {
      REQUIRE(choice.candidates[i].printable);
      REQUIRE_FALSE(choice.candidates[i].predicted_s);
      for (const auto& other : choice.candidates) {
        if (!other.predicted_s || choice.candidates[i].origin == orient::Origin::resting_face) continue;
        REQUIRE(other.direction.dot(choice.candidates[i].direction) < 0.9903);
      }
      choice.candidates[i].predicted_s = pretend(i);
      ++timed;
    }
    if (timed == 24) {
      double best = 1e300;
      for (const auto& c : choice.candidates)
        if (c.predicted_s) best = std::min(best, *c.predicted_s);
      CHECK(best <= 1.02 * pretend(fastest));
    }
  }
  CHECK(timed >= 24);
}

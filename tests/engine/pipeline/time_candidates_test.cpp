#include "engine/pipeline/time_candidates.h"

#include "engine/pipeline/baselines.h"
#include "engine/pipeline/slice_part.h"
#include "tests/support/meshes.h"

#include <atomic>
#include <set>

#include <catch2/catch.hpp>

using namespace voidpath;
using pipeline::PrepareOptions;

namespace {

PrepareOptions quick_options() {
  PrepareOptions o;
  o.orient.subdivisions = 1;
  o.print.slice.layer_height_mm = 0.4;
  o.print.slice.first_layer_height_mm = 0.4;
  return o;
}

PrepareOptions egg_options() {
  PrepareOptions o = quick_options();
  o.orient.limits.min_contact_mm2 = 0;
  o.orient.limits.stability_margin_mm = -1e3;
  return o;
}

struct Part {
  const char* name;
  mesh::TriangleMesh mesh;
};

std::vector<Part> parts() {
  const auto tall = mesh::rotated(test::table(30, 20, 24, 3, 4),
                                  geom::Quaternion(Eigen::AngleAxisd(0.7, geom::Vec3::UnitX())));
  return {{"box", test::box(8, 12, 30)},
          {"table", test::table(30, 20, 24, 3, 4)},
          {"leaning table", tall},
          {"comb", test::comb(4, 4, 4, 16, 3)},
          {"cup", test::cup(18, 14, 20, 2, 2)}};
}

/// With egg_options() it stands anywhere: no lack of candidates.
mesh::TriangleMesh egg() {
  auto mesh = test::sphere(6, 7, 12);
  for (auto& v : mesh.vertices) v = v.cwiseProduct(geom::Vec3(1, 1.3, 1.9));
  return mesh;
}

std::size_t count_timed(const orient::Choice& choice) {
  std::size_t n = 0;
  for (const auto& c : choice.candidates) n += c.predicted_s ? 1U : 0U;
  return n;
}

/// How many candidates the baselines are: several names may mean the same one.
std::size_t count_baselines(const orient::Choice& choice) {
  std::set<std::size_t> distinct;
  for (const auto& [name, i] : choice.baselines) distinct.insert(i);
  return distinct.size();
}

}  // namespace

TEST_CASE("the chosen direction is never slower than a baseline") {
  for (const Part& part : parts()) {
    CAPTURE(part.name);
    PrepareOptions o = quick_options();
    o.max_extra = 4;
    const orient::Choice choice = pipeline::choose(part.mesh, o, {});
    const auto& chosen = choice.candidates[choice.chosen];
    REQUIRE(chosen.predicted_s);
    CHECK(chosen.printable);
    CHECK(choice.baselines.count("thesis") == 1);
    CHECK(choice.baselines.count("ahsan") == 1);
    CHECK(choice.baselines.count("lowest") == 1);
    CHECK(choice.baselines.count("least overhang") == 1);
    for (const auto& [name, i] : choice.baselines) {
      CAPTURE(name);
      const auto& baseline = choice.candidates[i];
      if (!baseline.printable) continue;  // found out while slicing
      REQUIRE(baseline.predicted_s);
      CHECK(*chosen.predicted_s <= *baseline.predicted_s);
    }
    // What is told is what slicing that direction takes.
    CHECK(*chosen.predicted_s == pipeline::time_part(part.mesh, chosen.direction, o, {}));
  }
}

TEST_CASE("the published methods' picks are among the baselines when they can be printed") {
  for (const Part& part : parts()) {
    CAPTURE(part.name);
    PrepareOptions o = quick_options();
    const orient::Choice choice = orient::search(part.mesh, o.orient);
    const auto baselines = pipeline::find_baselines(choice);
    for (const auto method : {orient::Method::thesis, orient::Method::ahsan}) {
      o.orient.method = method;
      const orient::Choice published = orient::search(part.mesh, o.orient);
      const auto& winner = published.candidates[published.chosen];
      const auto weights = method == orient::Method::thesis ? orient::kThesisWeights : orient::kAhsanWeights;
      const auto same = pipeline::score_winner(choice, weights, pipeline::Only::any, o.orient.tie_tolerance);
      REQUIRE(same);
      CHECK(choice.candidates[*same].direction == winner.direction);
      if (!winner.printable) continue;
      CHECK(baselines.at(orient::to_string(method)) == *same);
    }
  }
}

TEST_CASE("without time left the baselines are timed, and nothing else") {
  PrepareOptions o = quick_options();
  o.budget_s = 0;
  std::atomic<int> ticks{0};
  o.now_s = [&] { return ticks++ * 1.0; };
  const orient::Choice choice = pipeline::choose(test::table(30, 20, 24, 3, 4), o, {});
  CHECK(choice.baselines.size() >= 8);
  CHECK(count_timed(choice) == count_baselines(choice));
}

TEST_CASE("the budget is kept by the clock, and more time means more candidates") {
  const auto mesh = egg();
  PrepareOptions o = egg_options();
  orient::Choice base = orient::search(mesh, o.orient);
  run::Context one;
  one.threads = 1;
  std::size_t before = 0;
  double best_before = 1e300;
  for (const double budget_s : {0.0, 150.0, 400.0}) {
    // Time passes only with being looked at: a second each time, several times a slicing.
    double now = 0;
    o.now_s = [&] { return now += 1; };
    o.budget_s = budget_s;
    orient::Choice choice = base;
    pipeline::time_candidates(mesh, o, choice, one);
    const std::size_t extra = count_timed(choice) - count_baselines(choice);
    if (budget_s > 0) {
      CHECK(extra > before);
      CHECK(now <= budget_s + 8);  // the last looks find that nothing is left
    }
    before = extra;
    const double best = *choice.candidates[choice.chosen].predicted_s;
    CHECK(best <= best_before);
    best_before = best;
  }
}

TEST_CASE("no candidate is started that would end after the budget") {
  const auto mesh = egg();
  PrepareOptions o = egg_options();
  run::Context one;
  one.threads = 1;
  // Slicing takes 10 s of this clock: it stands still but for while something is sliced.
  double now = 0;
  int looks = 0;
  o.now_s = [&] { return ++looks % 2 == 0 ? now : (now += 10); };
  o.budget_s = 5;
  orient::Choice choice = orient::search(mesh, o.orient);
  pipeline::time_candidates(mesh, o, choice, one);
  CHECK(count_timed(choice) == count_baselines(choice));
}

TEST_CASE("the choice does not depend on the number of threads") {
  for (const std::optional<std::size_t> extra :
       {std::optional<std::size_t>(), std::optional<std::size_t>(7)}) {
    PrepareOptions o = egg_options();
    o.max_extra = extra;
    const auto mesh = egg();
    run::Context one, many;
    one.threads = 1;
    many.threads = 5;
    const orient::Choice a = pipeline::choose(mesh, o, one);
    const orient::Choice b = pipeline::choose(mesh, o, many);
    CHECK(a.chosen == b.chosen);
    CHECK(a.ties == b.ties);
    CHECK(a.why == b.why);
    CHECK(count_timed(a) == count_baselines(a) + extra.value_or(0));
    for (std::size_t i = 0; i < a.candidates.size(); ++i)
      REQUIRE(a.candidates[i].predicted_s == b.candidates[i].predicted_s);
  }
}

TEST_CASE("a candidate that is timed already keeps its time") {
  const auto mesh = test::box(8, 12, 30);
  const PrepareOptions o = egg_options();
  orient::Choice choice = orient::search(mesh, o.orient);
  choice.candidates[choice.as_delivered].predicted_s = 1;  // far less than it takes
  pipeline::time_candidates(mesh, o, choice, {});
  CHECK(choice.candidates[choice.as_delivered].predicted_s == 1.0);
  CHECK(choice.chosen == choice.as_delivered);
}

TEST_CASE("timing stops when asked to") {
  const auto mesh = test::box(8, 12, 30);
  const PrepareOptions o = egg_options();
  orient::Choice choice = orient::search(mesh, o.orient);
  std::stop_source stop;
  stop.request_stop();
  run::Context ctx;
  ctx.stop = stop.get_token();
  CHECK_THROWS_AS(pipeline::time_candidates(mesh, o, choice, ctx), run::Stopped);
}

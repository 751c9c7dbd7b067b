#include "engine/pipeline/time_candidates.h"

#include "engine/pipeline/baselines.h"
#include "engine/pipeline/slice_part.h"
#include "tests/support/meshes.h"

#include <atomic>
#include <mutex>
#include <set>

#include <catch2/catch.hpp>

using namespace voidpath;
using pipeline::PrepareOptions;

namespace {

const geom::Vec3 kUp = geom::Vec3::UnitZ();

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
    CHECK(*chosen.predicted_s == pipeline::time_part(part.mesh, chosen, o, {}));
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

TEST_CASE("without time nothing is timed, and the answer says so") {
  PrepareOptions o = quick_options();
  o.budget_s = 0;
  std::atomic<int> ticks{0};
  o.now_s = [&] { return ticks++ * 1.0; };
  const auto mesh = test::table(30, 20, 24, 3, 4);
  const orient::Choice choice = pipeline::choose(mesh, o, {});
  CHECK(choice.baselines.size() >= 8);
  CHECK(count_timed(choice) == 0);
  CHECK_FALSE(choice.timing.complete);
  CHECK(choice.timing.budget_spent);
  CHECK(choice.timing.asked == count_baselines(choice));
  CHECK(choice.why.find("0 of " + std::to_string(choice.timing.asked) + " directions timed in full") !=
        std::string::npos);
  CHECK(choice.chosen == orient::search(mesh, o.orient).chosen);  // by its score
}

TEST_CASE("a budget that is not spent leaves no trace in the answer") {
  const auto mesh = test::table(30, 20, 24, 3, 4);
  PrepareOptions o = quick_options();
  std::vector<orient::Choice> choices;
  for (const double pace : {1e-6, 1e-3}) {  // a fast machine and a slow one
    double now = 0;
    std::mutex mutex;
    o.now_s = [&] {
      const std::lock_guard lock(mutex);
      return now += pace;
    };
    o.budget_s = 1000;
    choices.push_back(pipeline::choose(mesh, o, {}));
    CHECK(choices.back().timing.complete);
    CHECK_FALSE(choices.back().timing.budget_spent);
  }
  CHECK(choices[0].chosen == choices[1].chosen);
  CHECK(choices[0].why == choices[1].why);
  REQUIRE(choices[0].candidates.size() == choices[1].candidates.size());
  for (std::size_t i = 0; i < choices[0].candidates.size(); ++i)
    CHECK(choices[0].candidates[i].predicted_s == choices[1].candidates[i].predicted_s);
}

TEST_CASE("a long box is turned about the build axis when its infill prints faster so") {
  // Lines along a bar are few and long; at 45 degrees, as the profile has them, they are many and short.
  auto o = quick_options();
  o.max_extra = 4;
  const auto mesh = test::box(8, 60, 5);
  const orient::Choice choice = pipeline::choose(mesh, o, {});
  std::size_t turned = 0;
  for (const auto& c : choice.candidates) turned += c.turn_rad != 0 ? 1U : 0U;
  CHECK(turned > 0);
  const auto& chosen = choice.candidates[choice.chosen];
  REQUIRE(chosen.predicted_s);
  for (const auto& c : choice.candidates)
    if (c.printable && c.predicted_s) CHECK(*chosen.predicted_s <= *c.predicted_s);
  CHECK(*chosen.predicted_s == pipeline::time_part(mesh, chosen, o, {}));
}

TEST_CASE("a turn that does not fit the bed is refused") {
  auto o = quick_options();
  o.print.machine.bed_mm = {40, 90};
  const auto mesh = test::box(8, 70, 5);
  CHECK(pipeline::time_part(mesh, kUp, o, {}) > 0);
  CHECK_THROWS_AS(pipeline::time_part(mesh, pipeline::Pose(geom::Vec3::UnitZ(), 1.57), o, {}),
                  pipeline::Refused);
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
    CHECK(count_timed(a) >= count_baselines(a) + extra.value_or(0));
    REQUIRE(a.candidates.size() == b.candidates.size());
    for (std::size_t i = 0; i < a.candidates.size(); ++i)
      REQUIRE((a.candidates[i].predicted_s == b.candidates[i].predicted_s &&
               a.candidates[i].sampled_s == b.candidates[i].sampled_s));
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

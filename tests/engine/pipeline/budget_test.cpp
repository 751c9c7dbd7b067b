#include "engine/pipeline/budget.h"

#include "engine/pipeline/baselines.h"
#include "engine/pipeline/sample_time.h"
#include "engine/pipeline/search_in_time.h"
#include "engine/pipeline/slice_part.h"
#include "engine/pipeline/time_candidates.h"
#include "tests/support/meshes.h"

#include <atomic>

#include <catch2/catch.hpp>

using namespace voidpath;
using pipeline::PrepareOptions;

namespace {

/// Time that passes only with being looked at: each look, which is once a unit of work, takes as long.
class WorkClock {
 public:
  explicit WorkClock(double pace_s) : pace_s_(pace_s) {}
  double now_s() { return static_cast<double>(++looks_) * pace_s_; }
  double seen_s() const { return static_cast<double>(looks_.load()) * pace_s_; }

 private:
  double pace_s_;
  std::atomic<long> looks_{0};
};

PrepareOptions options() {
  PrepareOptions o;
  o.orient.subdivisions = 2;
  o.print.slice.layer_height_mm = 0.1;
  o.print.slice.first_layer_height_mm = 0.1;
  return o;
}

mesh::TriangleMesh part() {
  return mesh::rotated(test::table(15, 10, 12, 2, 2),
                       geom::Quaternion(Eigen::AngleAxisd(0.7, geom::Vec3::UnitX())));
}

std::size_t count_full(const orient::Choice& choice) {
  std::size_t n = 0;
  for (const auto& c : choice.candidates) n += c.predicted_s ? 1U : 0U;
  return n;
}

std::size_t count_unknown_baselines(const orient::Choice& choice) {
  std::size_t n = 0;
  for (const auto& [name, i] : choice.baselines) {
    const auto& c = choice.candidates[i];
    n += c.printable && !c.predicted_s && !c.sampled_s ? 1U : 0U;
  }
  return n;
}

/// What a user is told: the chosen one against each baseline, like with like.
void check_never_slower(const orient::Choice& choice) {
  const auto& chosen = choice.candidates[choice.chosen];
  for (const auto& [name, i] : choice.baselines) {
    CAPTURE(name);
    const auto& baseline = choice.candidates[i];
    if (!baseline.printable) continue;
    if (chosen.predicted_s && baseline.predicted_s) CHECK(*chosen.predicted_s <= *baseline.predicted_s);
    if (!chosen.predicted_s && !baseline.predicted_s && chosen.sampled_s && baseline.sampled_s)
      CHECK(*chosen.sampled_s <= *baseline.sampled_s);
  }
}

struct Run {
  orient::Choice choice;
  double took_s = 0;
};

Run run_at(double pace_s, double budget_s, const mesh::TriangleMesh& mesh) {
  WorkClock clock(pace_s);
  PrepareOptions o = options();
  o.budget_s = budget_s;
  o.now_s = [&] { return clock.now_s(); };
  run::Context one;
  one.threads = 1;
  Run out;
  out.choice = pipeline::choose(mesh, o, one);
  out.took_s = clock.seen_s();
  return out;
}

}  // namespace

TEST_CASE("the budget is kept at any pace, and the answer is no worse with more of it") {
  const auto mesh = part();
  const double all_s = run_at(1, 1e12, mesh).took_s;
  std::size_t before = 0;
  bool cut_search = false, cut_samples = false, cut_full = false, whole = false;
  for (const double share : {0.002, 0.01, 0.05, 0.2, 0.3, 0.5, 0.8, 2.0}) {
    CAPTURE(share);
    const double budget_s = share * all_s;
    const Run r = run_at(1, budget_s, mesh);
    // Some looks find that nothing is left.
    CHECK(r.took_s <= budget_s + 60);
    check_never_slower(r.choice);
    const std::size_t full = count_full(r.choice);
    CHECK(full >= before);
    before = full;
    cut_search = cut_search || r.choice.why.find("for want of time only") != std::string::npos;
    cut_samples = cut_samples || count_unknown_baselines(r.choice) > 0;
    cut_full = cut_full || (count_unknown_baselines(r.choice) == 0 && !r.choice.timing.complete);
    whole = whole || (r.choice.timing.complete && !r.choice.timing.budget_spent);
    CHECK((count_unknown_baselines(r.choice) > 0) ==
          (r.choice.why.find("could not be looked at") != std::string::npos));
  }
  // Each way of running out of time was met.
  CHECK(cut_search);
  CHECK(cut_samples);
  CHECK(cut_full);
  CHECK(whole);
}

TEST_CASE("what turning saves is told by the whole part as it came where time allows, else by a sample") {
  const auto mesh = part();  // does not stand as it came
  const auto as_delivered = [&](double budget_s) {
    const auto choice = run_at(1, budget_s, mesh).choice;
    return choice.candidates[choice.as_delivered];
  };
  const orient::Candidate exact = as_delivered(1e12);
  REQUIRE_FALSE(exact.printable);
  REQUIRE(exact.predicted_s);
  const PrepareOptions how = pipeline::held(options(), exact);
  CHECK(*exact.predicted_s == pipeline::time_part(mesh, exact, how, {}));
  const double all_s = run_at(1, 1e12, mesh).took_s;
  bool rough = false;
  for (const double share : {0.2, 0.3, 0.4, 0.5, 0.6}) {
    const orient::Candidate c = as_delivered(share * all_s);
    rough = rough || (c.sampled_s && !c.predicted_s);
    if (c.sampled_s) CHECK(*c.sampled_s == pipeline::sample_time(mesh, c, how, {}).seconds);
  }
  CHECK(rough);
}

TEST_CASE("when time is short every baseline gets a shorter look rather than some of them none") {
  const auto mesh = part();
  PrepareOptions o = options();
  o.max_extra = 0;
  const orient::Choice base = orient::search(mesh, o.orient);
  run::Context one;
  one.threads = 1;
  const auto timed_within = [&](double budget_s) {
    WorkClock clock(1);
    o.budget_s = budget_s;
    o.now_s = [&] { return clock.now_s(); };
    orient::Choice choice = base;
    pipeline::time_candidates(mesh, o, choice, one);
    return std::pair(choice, clock.seen_s());
  };
  const auto [whole, whole_s] = timed_within(1e12);
  REQUIRE(whole.timing.complete);
  const auto [choice, took_s] = timed_within(0.30 * whole_s);
  CHECK(took_s <= 0.30 * whole_s + 60);
  CHECK(count_unknown_baselines(choice) == 0);
  CHECK_FALSE(choice.timing.complete);
  check_never_slower(choice);
  std::size_t usual = 0, shorter = 0;
  for (std::size_t i = 0; i < choice.candidates.size(); ++i) {
    const auto& c = choice.candidates[i];
    if (!c.sampled_s || !c.printable) continue;
    const double few_s = pipeline::sample_time(mesh, c, o, {}, pipeline::kFewSamples).seconds;
    const double many_s = pipeline::sample_time(mesh, c, o, {}).seconds;
    REQUIRE(few_s != many_s);
    CHECK((*c.sampled_s == few_s || *c.sampled_s == many_s));
    (*c.sampled_s == few_s ? shorter : usual) += 1;
  }
  CHECK(usual > 0);
  CHECK(shorter > 0);
}

TEST_CASE("a search that would take the whole budget looks at fewer directions") {
  const auto mesh = part();
  PrepareOptions o = options();
  WorkClock clock(1);
  o.now_s = [&] { return clock.now_s(); };
  o.budget_s = 1e12;
  run::Context one;
  one.threads = 1;
  std::size_t all = 0;
  double all_s = 0;
  {
    const pipeline::Budget budget(o);
    const auto found = pipeline::search_in_time(mesh, o, budget, one);
    CHECK_FALSE(found.coarser);
    all = found.choice.candidates.size();
    all_s = clock.seen_s();
  }
  std::size_t before = all;
  for (const double share : {1.0, 0.3, 0.01}) {
    CAPTURE(share);
    o.budget_s = share * all_s;
    const pipeline::Budget budget(o);
    const auto found = pipeline::search_in_time(mesh, o, budget, one);
    CHECK(found.coarser);
    CHECK(found.choice.candidates.size() <= before);
    CHECK(found.choice.candidates.size() < all);
    before = found.choice.candidates.size();
    CHECK(found.choice.candidates[found.choice.as_delivered].direction == geom::Vec3::UnitZ());
    const auto baselines = pipeline::find_baselines(found.choice);
    CHECK(baselines.count("resting face 1") == 1);
    // A search that was broken off leaves half of the time and more to what decides.
    if (share == 1.0) CHECK(budget.spent() < 0.6 * o.budget_s);
  }
  o.budget_s = 0;
  const pipeline::Budget none(o);
  const auto by_score = pipeline::search_in_time(mesh, o, none, one);
  CHECK_FALSE(by_score.coarser);
  CHECK(by_score.choice.candidates.size() == all);
}

TEST_CASE("a stop is a stop, the end of the budget is none") {
  PrepareOptions o;
  double now = 0;
  o.now_s = [&] { return now; };
  o.budget_s = 10;
  const pipeline::Budget budget(o);
  std::stop_source stop;
  run::Context ctx;
  ctx.stop = stop.get_token();
  const auto work = [](const run::Context& inner) { inner.check(); };
  CHECK(pipeline::ended_in_time(budget, ctx, work));
  CHECK(budget.left() == 10);
  now = 11;
  CHECK_FALSE(pipeline::ended_in_time(budget, ctx, work));
  CHECK(budget.left() == 0);
  CHECK_FALSE(budget.has_room(0));
  CHECK_NOTHROW(ctx.check());
  stop.request_stop();
  CHECK_THROWS_AS(pipeline::ended_in_time(budget, ctx, work), run::Stopped);
}

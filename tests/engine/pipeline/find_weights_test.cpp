#include "engine/pipeline/find_weights.h"

#include "engine/orient/score.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>

#include <catch2/catch.hpp>

using namespace voidpath;
using pipeline::ModelWeights;

namespace {

constexpr double kTie = 1e-9;

orient::Candidate candidate(double h, double v, double d, double c) {
  orient::Candidate out;
  out.criteria = {h, v, c, d};
  return out;
}

/// Four candidates, each the best by one criterion alone and the worst by the others.
orient::Choice four_corners() {
  orient::Choice choice;
  choice.method = orient::Method::thesis;
  choice.candidates = {candidate(0, 1, 1, 1), candidate(1, 0, 1, 1), candidate(1, 1, 0, 1),
                       candidate(1, 1, 1, 0)};
  return choice;
}

double sum(const orient::Weights& w) { return w.h + w.v + w.d + w.c; }

}  // namespace

TEST_CASE("the tuples of weights are all there once, multiples taken together") {
  const auto& tuples = pipeline::weight_tuples();
  std::set<std::array<long, 4>> seen;
  for (const auto& w : tuples) {
    CHECK(sum(w) == Approx(1));
    seen.insert(
        {std::lround(w.h * 1e9), std::lround(w.v * 1e9), std::lround(w.d * 1e9), std::lround(w.c * 1e9)});
  }
  CHECK(seen.size() == tuples.size());
  // Every tuple of the grid but the one of zeros is a multiple of one of them.
  std::set<std::array<long, 4>> grid;
  std::size_t count = 0;
  for (int h = 0; h <= 10; ++h)
    for (int v = 0; v <= 10; ++v)
      for (int d = 0; d <= 10; ++d)
        for (int c = 0; c <= 10; ++c) {
          ++count;
          const double s = h + v + d + c;
          if (s > 0)
            grid.insert({std::lround(h / s * 1e9), std::lround(v / s * 1e9), std::lround(d / s * 1e9),
                         std::lround(c / s * 1e9)});
        }
  CHECK(count == pipeline::kAllTuples);
  CHECK(grid == seen);
}

TEST_CASE("each tuple picks the candidate of least score") {
  const orient::Choice choice = four_corners();
  const auto picks = pipeline::picks_of_tuples(choice, kTie);
  REQUIRE(picks.size() == pipeline::weight_tuples().size());
  for (std::size_t i = 0; i < picks.size(); ++i) {
    const auto& w = pipeline::weight_tuples()[i];
    const double weights[] = {w.h, w.v, w.d, w.c};
    // The heaviest weight wins; of equals the first candidate does.
    const auto heaviest = std::max_element(std::begin(weights), std::end(weights),
                                           [](double a, double b) { return a < b - kTie; });
    REQUIRE(picks[i] == static_cast<std::size_t>(heaviest - std::begin(weights)));
  }
}

TEST_CASE("tuples pick what the search would choose with them") {
  orient::SearchOptions options;
  options.subdivisions = 1;
  for (const auto method : {orient::Method::thesis, orient::Method::toolpath}) {
    options.method = method;
    const auto mesh = test::table(60, 40, 30, 3, 5);
    const orient::Choice choice = orient::search(mesh, options);
    const auto picks = pipeline::picks_of_tuples(choice, options.tie_tolerance);
    for (std::size_t i = 7; i < picks.size(); i += 1111) {
      options.weights = pipeline::weight_tuples()[i];
      const orient::Choice again = orient::search(mesh, options);
      CHECK(picks[i] == again.chosen);
    }
  }
}

TEST_CASE("a candidate that cannot be printed is picked by the published method only") {
  orient::Choice choice = four_corners();
  choice.candidates[0].printable = false;
  const auto has_first = [&] {
    const auto picks = pipeline::picks_of_tuples(choice, kTie);
    return std::count(picks.begin(), picks.end(), 0U) > 0;
  };
  CHECK(has_first());
  choice.method = orient::Method::toolpath;
  CHECK_FALSE(has_first());
}

TEST_CASE("a model's optimum are the tuples that lead to the least time") {
  const orient::Choice choice = four_corners();
  std::mutex mutex;
  std::multiset<std::size_t> asked;
  const auto time_of = [&](std::size_t i) -> std::optional<double> {
    const std::lock_guard lock(mutex);
    asked.insert(i);
    return i == 1 ? 100.0 : 200.0 + static_cast<double>(i);
  };
  for (const unsigned threads : {1U, 4U}) {
    asked.clear();
    run::Context ctx;
    ctx.threads = threads;
    const ModelWeights m = pipeline::weigh_model(choice, kTie, time_of, ctx);
    CHECK(asked == std::multiset<std::size_t>{0, 1, 2, 3});  // each direction once
    CHECK(m.directions == 4);
    CHECK(m.timed == 4);
    CHECK(m.best_s == 100);
    CHECK(m.worst_s == 203);
    REQUIRE(m.median);
    CHECK(sum(*m.median) == Approx(1));
    CHECK(m.median->v > m.median->h);
    CHECK(m.median->v > m.median->d);
    CHECK(m.median->v > m.median->c);
  }
}

TEST_CASE("a model that prints alike in all directions has no vote, nor has one that cannot be timed") {
  const orient::Choice choice = four_corners();
  const auto alike = pipeline::weigh_model(
      choice, kTie, [](std::size_t i) { return 100 + 0.01 * static_cast<double>(i); }, {});
  CHECK_FALSE(alike.median);
  CHECK(alike.optimal_tuples == pipeline::weight_tuples().size());
  const auto refused = pipeline::weigh_model(choice, kTie, [](std::size_t) { return std::nullopt; }, {});
  CHECK_FALSE(refused.median);
  CHECK(refused.timed == 0);
  CHECK(refused.directions == 4);
  CHECK_FALSE(pipeline::median_weights({alike, refused}));
}

TEST_CASE("a direction that cannot be timed is no one's optimum") {
  const orient::Choice choice = four_corners();
  const auto m = pipeline::weigh_model(choice, kTie,
                                       [](std::size_t i) -> std::optional<double> {
                                         if (i == 1) return std::nullopt;
                                         return i == 2 ? 50.0 : 60.0;
                                       },
                                       {});
  CHECK(m.timed == 3);
  REQUIRE(m.median);
  CHECK(m.median->d > m.median->v);
}

TEST_CASE("the weights are the median over the models, an odd one out moves nothing") {
  const auto vote = [](double h, double v, double d, double c) {
    ModelWeights m;
    m.median = orient::Weights{h, v, d, c};
    return m;
  };
  std::vector<ModelWeights> models = {vote(0.4, 0.3, 0.1, 0.2), vote(0.3, 0.3, 0.2, 0.2),
                                      vote(0.5, 0.2, 0.1, 0.2)};
  const auto w = pipeline::median_weights(models);
  REQUIRE(w);
  CHECK(w->h == Approx(0.4));
  CHECK(w->v == Approx(0.3));
  CHECK(w->d == Approx(0.1));
  CHECK(w->c == Approx(0.2));
  models[2] = vote(1, 0, 0, 0);
  CHECK(pipeline::median_weights(models)->h == Approx(w->h));
  models.push_back({});  // without a vote
  CHECK(pipeline::median_weights(models)->h == Approx(w->h));
  // Where each model swears by another criterion the medians are all 0.
  const auto mean = pipeline::median_weights({vote(1, 0, 0, 0), vote(0, 1, 0, 0), vote(0, 0, 1, 0)});
  REQUIRE(mean);
  CHECK(mean->h == Approx(1.0 / 3));
  CHECK(mean->c == 0);
}

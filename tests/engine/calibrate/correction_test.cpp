#include "engine/calibrate/correction.h"

#include <algorithm>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

using namespace voidpath::calibrate;

namespace {

std::vector<Observation> planted(double factor, int count, double noise = 0) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> spread(-noise, noise);
  std::vector<Observation> rows;
  for (int i = 0; i < count; ++i) {
    const double predicted = 100.0 + 37.0 * i;
    rows.push_back({predicted, predicted * factor * (1 + spread(random))});
  }
  return rows;
}

}  // namespace

TEST_CASE("a planted factor is found") {
  for (const double factor : {0.8, 1.0, 1.07, 1.6}) {
    const auto exact = fit_correction(planted(factor, 5));
    REQUIRE(exact);
    CHECK(exact->factor == Approx(factor).epsilon(1e-12));
    CHECK(exact->used == 5);
    CHECK(exact->rejected == 0);
    const auto noisy = fit_correction(planted(factor, 25, 0.02));
    REQUIRE(noisy);
    CHECK(noisy->factor == Approx(factor).epsilon(0.01));
    CHECK(noisy->spread < 0.03);
  }
}

TEST_CASE("outliers do not move the factor, and are counted") {
  auto rows = planted(1.1, 9, 0.01);
  const double before = fit_correction(rows)->factor;
  rows.push_back({1000, 5000});  // a print with an unseen stop
  rows.push_back({1000, 100});
  const auto fit = fit_correction(rows);
  REQUIRE(fit);
  CHECK(fit->factor == Approx(before).epsilon(0.005));
  CHECK(fit->rejected == 2);
  CHECK(fit->used == 9);
}

TEST_CASE("too few rows give no factor, and unusable ones are no rows") {
  CHECK_FALSE(fit_correction({}));
  CHECK_FALSE(fit_correction(planted(1.2, 2)));
  CHECK(fit_correction(planted(1.2, 3)));
  auto rows = planted(1.2, 2);
  rows.push_back({0, 10});
  rows.push_back({100, 0});
  rows.push_back({kMinSpan_s / 2, kMinSpan_s});
  rows.push_back({std::numeric_limits<double>::quiet_NaN(), 10});
  rows.push_back({100, std::numeric_limits<double>::infinity()});
  CHECK_FALSE(fit_correction(rows));
}

TEST_CASE("three rows that disagree by far give none: two of them cannot outvote the third") {
  // Median 1, deviation 1: all within reach, so the median stands; with a tight pair the third is dropped
  // and two are too few.
  CHECK_FALSE(fit_correction({{100, 100}, {100, 101}, {100, 300}}));
}

TEST_CASE("the factor is bounded") {
  CHECK(fit_correction(planted(0.1, 5))->factor == kMinFactor);
  CHECK(fit_correction(planted(9.0, 5))->factor == kMaxFactor);
}

TEST_CASE("the order of the rows does not matter") {
  auto rows = planted(1.05, 12, 0.03);
  const double factor = fit_correction(rows)->factor;
  std::reverse(rows.begin(), rows.end());
  CHECK(fit_correction(rows)->factor == factor);
}

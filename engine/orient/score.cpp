#include "engine/orient/score.h"

#include <algorithm>

namespace voidpath::orient {

namespace {

/// Spreads below this share of the values are rounding (of a sphere's height, say), not differences.
constexpr double kSpreadNoise = 1e-9;

}  // namespace

void score(std::vector<Candidate>& candidates, const Weights& weights) {
  struct Term {
    double Criteria::*value;
    double weight;
  };
  const Term terms[] = {{&Criteria::height_mm, weights.h},
                        {&Criteria::trapped_mm3, weights.v},
                        {&Criteria::void_mm, weights.d},
                        {&Criteria::contours, weights.c}};
  for (Candidate& c : candidates) c.score = 0;
  for (const auto& [value, weight] : terms) {
    const auto [low, high] = std::minmax_element(
        candidates.begin(), candidates.end(),
        [v = value](const Candidate& a, const Candidate& b) { return a.criteria.*v < b.criteria.*v; });
    if (low == candidates.end()) return;
    const double least = low->criteria.*value;
    const double spread = high->criteria.*value - least;
    if (!(spread > kSpreadNoise * high->criteria.*value)) continue;
    for (Candidate& c : candidates) c.score += weight * (c.criteria.*value - least) / spread;
  }
}

}  // namespace voidpath::orient

#include "engine/pipeline/next_candidates.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace voidpath::pipeline {

namespace {

using orient::Candidate;

constexpr int kFeatures = 7;  ///< a constant, H, V, C, D, contact, overhang
using Row = Eigen::Matrix<double, kFeatures, 1>;

/// Fewer timed candidates than this say less than the score does.
constexpr std::size_t kEnoughTimed = 8;
/// Of the regression, per coefficient but the constant: holds what the timed candidates don't tell near 0.
/// Times are logarithms, features in [0, 1]: one timed candidate at the far end outweighs it.
constexpr double kRidge = 0.3;
/// Candidates nearer to one another than this print alike: time the first only. cos of 8°
constexpr double kAlike_cos = 0.990;
/// As far as refinement looks around the quickest. cos of 40°
constexpr double kNear_cos = 0.766;

}  // namespace

NextCandidates::NextCandidates(const orient::Choice& choice, const std::vector<Underside>& under,
                               KnownTime known)
    : choice_(choice), known_(std::move(known)), features_(choice.candidates.size()) {
  std::array<double, kFeatures> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const Candidate& c = choice.candidates[i];
    if (!c.printable) continue;
    const auto& k = c.criteria;
    features_[i] = {1,         k.height_mm,          k.trapped_mm3,        k.contours,
                    k.void_mm, under[i].contact_mm2, under[i].overhang_mm2};
    for (std::size_t f = 0; f < kFeatures; ++f) {
      low[f] = std::min(low[f], features_[i][f]);
      high[f] = std::max(high[f], features_[i][f]);
    }
  }
  for (auto& row : features_)
    for (std::size_t f = 1; f < row.size(); ++f) {
      const double spread = high[f] - low[f];
      row[f] = spread > 0 ? (row[f] - low[f]) / spread : 0;
    }
}

std::vector<double> NextCandidates::predict() const {
  Eigen::Matrix<double, kFeatures, kFeatures> normal =
      kRidge * Eigen::Matrix<double, kFeatures, kFeatures>::Identity();
  normal(0, 0) = 1e-9;  // the constant is free; this only keeps the matrix regular
  Row right = Row::Zero();
  std::size_t timed = 0;
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const Candidate& c = choice_.candidates[i];
    const auto time = known_(i);
    if (!time || !c.printable) continue;
    const Row x = Row::Map(features_[i].data());
    normal += x * x.transpose();
    right += x * std::log(std::max(*time, 1e-3));
    ++timed;
  }
  std::vector<double> out(features_.size(), std::numeric_limits<double>::infinity());
  const Row beta = normal.ldlt().solve(right);
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (!choice_.candidates[i].printable) continue;
    out[i] = timed < kEnoughTimed ? choice_.candidates[i].score : beta.dot(Row::Map(features_[i].data()));
  }
  return out;
}

std::vector<std::size_t> NextCandidates::next(std::size_t count) const {
  const auto& all = choice_.candidates;
  std::vector<std::size_t> open;
  std::vector<geom::Vec3> seen;
  std::optional<std::size_t> best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < features_.size(); ++i) {
    const auto time = known_(i);
    if (!time) {
      if (all[i].printable) open.push_back(i);
      continue;
    }
    seen.push_back(all[i].direction);
    if (all[i].printable && *time < least) best = i, least = *time;
  }
  const std::vector<double> predicted = predict();
  const auto nearness = [&](std::size_t i) {
    const double cos = best ? all[*best].direction.dot(all[i].direction) : -1;
    return cos > kNear_cos ? -cos : std::numeric_limits<double>::infinity();
  };
  // A resting face is never "like" a sampled direction beside it: lying flat is what makes it different.
  const auto is_new = [&](std::size_t i) {
    return all[i].origin == orient::Origin::resting_face ||
           std::none_of(seen.begin(), seen.end(),
                        [&](const geom::Vec3& s) { return s.dot(all[i].direction) > kAlike_cos; });
  };

  std::vector<std::size_t> out;
  for (std::size_t turn = 0; out.size() < count && !open.empty(); ++turn) {
    std::erase_if(open, [&](std::size_t i) { return !is_new(i); });
    const auto first = [&](const auto& value) {
      return std::min_element(open.begin(), open.end(),
                              [&](std::size_t a, std::size_t b) { return value(a) < value(b); });
    };
    const auto by_prediction = [&](std::size_t i) { return predicted[i]; };
    auto pick = first(by_prediction);
    if (turn % 4 == 2) pick = first([&](std::size_t i) { return all[i].score; });
    if (turn % 4 == 3) {
      const auto near = first(nearness);
      if (near != open.end() && std::isfinite(nearness(*near))) pick = near;
    }
    if (pick == open.end()) break;
    out.push_back(*pick);
    seen.push_back(all[*pick].direction);
    open.erase(pick);
  }
  return out;
}

}  // namespace voidpath::pipeline

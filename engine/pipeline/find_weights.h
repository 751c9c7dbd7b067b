#pragma once

#include "engine/orient/search.h"
#include "engine/run/context.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

/// Finding the weights of the four criteria for a printer (J. Garcia, 2017, §3.4): every tuple of weights
/// from {0, 0.1, ... 1} picks a direction of each model; the tuples whose pick prints fastest are that
/// model's optimum; the printer's weights are the median over the models.
namespace voidpath::pipeline {

/// The tuples of {0, 0.1, ... 1}⁴ that rank differently: of those that are multiples of one another, one;
/// without the one that weighs nothing. Each sums to 1. Always in the same order.
const std::vector<orient::Weights>& weight_tuples();
/// All there are before multiples are taken together: 11⁴.
inline constexpr std::size_t kAllTuples = 14'641;

/// What each of weight_tuples() picks, by the rules of orient::search(): an index into choice.candidates. For
/// Method::toolpath only printable candidates can be picked, unless there is none.
std::vector<std::size_t> picks_of_tuples(const orient::Choice& choice, double tie_tolerance);

/// Times this near, as a share, count as equal: the planner is no better than that against real firmware, and
/// a symmetric part's equal directions differ by as much in where seams and infill lines fall.
inline constexpr double kSameTime = 1e-3;

/// One model's vote.
struct ModelWeights {
  std::size_t directions = 0;      ///< that tuples pick
  std::size_t timed = 0;           ///< of these, could be timed
  std::size_t optimal_tuples = 0;  ///< of weight_tuples(), whose pick is as quick as any
  double best_s = 0;               ///< quickest and slowest pick
  double worst_s = 0;
  /// Of each weight over the optimal tuples, summing to 1. Absent when the model says nothing: nothing could
  /// be timed, or every tuple leads to the same time.
  std::optional<orient::Weights> median;
};

/// Seconds to print with that candidate up; nothing when it cannot be printed. Called once a direction, from
/// several threads at once.
using TimeOf = std::function<std::optional<double>(std::size_t candidate)>;

/// `choice` comes from orient::search(). Throws run::Stopped and what `time_of` throws.
ModelWeights weigh_model(const orient::Choice& choice, double tie_tolerance, const TimeOf& time_of,
                         const run::Context& ctx);

/// The median over the models that say something, normalised to a sum of 1; where the medians are all 0, the
/// mean. Nothing without such a model.
std::optional<orient::Weights> median_weights(const std::vector<ModelWeights>& models);

}  // namespace voidpath::pipeline

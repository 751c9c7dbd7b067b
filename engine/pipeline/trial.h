#pragma once

#include "engine/pipeline/budget.h"
#include "engine/pipeline/prepare.h"

#include <cstddef>
#include <functional>
#include <mutex>
#include <optional>
#include <vector>

namespace voidpath::pipeline {

/// Times candidates of one choice: on a sample of their layers, or in full. Which come first is the caller's
/// affair. Steps are the same on one thread and on many. The budget is looked at before each candidate, and
/// what is under way when it ends is given up: only there may two machines differ.
class Trial {
 public:
  /// All must outlive it.
  Trial(const mesh::TriangleMesh& mesh, const PrepareOptions& options, orient::Choice& choice,
        const run::Context& ctx);

  /// On a sample of layers; a part of few layers is timed in full at once. Those known already are passed
  /// over, those that turn out not to be printable are marked so. `few`: on fewer layers, for a hurry.
  void sample(const std::vector<std::size_t>& which, bool few = false);
  /// What sampling so many more would take on all threads, going by those so far.
  double expected_sampling_s(std::size_t count) const;
  /// What timing a sampled one in full would take; 0 when it was not sampled.
  double expected_full_s(std::size_t i) const;
  /// Times in full, least sampled time first, whoever may be quicker than the quickest so far as far as the
  /// samples can be trusted. False when the budget ended that.
  bool settle(const std::vector<std::size_t>& among);
  /// Times in full whatever is not yet, least sampled time first, as far as the budget reaches.
  bool time_rest(const std::vector<std::size_t>& among);

  /// Full time, or the sampled one corrected by how full times compare with it; nothing when not timed.
  std::optional<double> known(std::size_t i) const;
  /// Samples can be wrong by this share, after correction.
  double sample_error() const;
  /// The quickest in full.
  std::optional<std::size_t> best() const;
  const Budget& budget() const { return budget_; }
  bool budget_spent() const { return budget_spent_; }

 private:
  struct Cost {
    double sample_s = 0;  ///< of the caller's clock
    double share = 1;     ///< of layers that were planned
  };

  void time_full(const std::vector<std::size_t>& which);
  /// False when the budget ended before the last of them.
  bool run(const std::vector<std::size_t>& which,
           const std::function<void(std::size_t, const run::Context&)>& body);
  double expected_sample_s(bool few) const;
  std::vector<double> deviations() const;
  double bias() const;
  bool settle_while(const std::vector<std::size_t>& among, const std::function<bool(std::size_t)>& wanted);

  const mesh::TriangleMesh& mesh_;
  const PrepareOptions& options_;
  orient::Choice& choice_;
  const run::Context& ctx_;
  Budget budget_;
  bool budget_spent_ = false;
  std::vector<Cost> costs_;
  mutable std::mutex mutex_;
  struct Spent {
    double seconds = 0;
    int count = 0;
  };
  Spent samples_, few_samples_;
  double full_over_sample_ = 0;  ///< sum of the ratios of costs
  int fulls_ = 0;
};

}  // namespace voidpath::pipeline

#pragma once

#include "engine/orient/search.h"
#include "engine/pipeline/least_overhang.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

namespace voidpath::pipeline {

/// What is known of a candidate's time; nothing when it was not timed.
using KnownTime = std::function<std::optional<double>(std::size_t)>;

/// Which candidates to time next, given those timed so far. Candidates that the choice got after this was
/// made are none of its business.
///
/// Time is predicted for every printable candidate by a ridge regression over what is known without slicing:
/// the four criteria, contact and overhang, each scaled to [0, 1]. Fitted to the candidates timed so far; as
/// long as they are few, the weighted score ranks instead. Deterministic; keeps no clock.
class NextCandidates {
 public:
  /// Both must outlive it; `under` belongs to the candidates one by one.
  NextCandidates(const orient::Choice& choice, const std::vector<Underside>& under, KnownTime known);

  /// At most `count` printable candidates not timed yet, none like another of them or (but for resting faces)
  /// like one timed already: by turns the quickest predicted, the nearest to the quickest timed, and the best
  /// by score. Fewer, then none, when they run out.
  std::vector<std::size_t> next(std::size_t count) const;

 private:
  std::vector<double> predict() const;

  const orient::Choice& choice_;
  KnownTime known_;
  std::vector<std::vector<double>> features_;  ///< per candidate, scaled; empty where not printable
};

}  // namespace voidpath::pipeline

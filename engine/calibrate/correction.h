#pragma once

#include <cstddef>
#include <optional>
#include <vector>

/// What finished prints say about the next prediction.
namespace voidpath::calibrate {

/// One finished print: what the planner said and what the printer's clock said, s, of the same span.
struct Observation {
  double predicted_s = 0;
  double measured_s = 0;
};

/// Bounds of a learned factor. A planner that is off by more than a factor of two has the wrong profile, and
/// no factor repairs that.
inline constexpr double kMinFactor = 0.5;
inline constexpr double kMaxFactor = 2.0;
/// Fewer observations give no factor: one odd print must not bend the next prediction.
inline constexpr std::size_t kMinObservations = 3;
/// Prints shorter than this say more about start and end than about motion, s.
inline constexpr double kMinSpan_s = 10.0;

struct Correction {
  double factor = 1.0;       ///< predicted = raw × factor
  std::size_t used = 0;      ///< observations the factor rests on
  std::size_t rejected = 0;  ///< outliers and unusable rows
  double spread = 0;         ///< median absolute deviation of the ratios used, relative to the factor
};

/// The median ratio of measured to predicted after outliers are dropped (further than three scaled median
/// absolute deviations from the median, and at least 5 %), clamped to [kMinFactor, kMaxFactor].
/// Empty when fewer than kMinObservations usable rows remain.
std::optional<Correction> fit_correction(const std::vector<Observation>& rows);

}  // namespace voidpath::calibrate

#include "engine/calibrate/correction.h"

#include <algorithm>
#include <cmath>

namespace voidpath::calibrate {
namespace {

/// Makes the median absolute deviation comparable to a standard deviation of normal noise.
constexpr double kMadToSigma = 1.4826;
constexpr double kOutlierSigmas = 3.0;
/// Relative. Prints of one printer that agree to the millisecond must not make the next one an outlier.
constexpr double kOutlierFloor = 0.05;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*middle + *std::max_element(values.begin(), middle)) / 2;
}

double deviation(const std::vector<double>& values, double centre) {
  std::vector<double> distance;
  distance.reserve(values.size());
  for (const double value : values) distance.push_back(std::abs(value - centre));
  return median(std::move(distance));
}

bool usable(const Observation& row) {
  return std::isfinite(row.predicted_s) && std::isfinite(row.measured_s) && row.predicted_s >= kMinSpan_s &&
         row.measured_s > 0;
}

}  // namespace

std::optional<Correction> fit_correction(const std::vector<Observation>& rows) {
  std::vector<double> ratios;
  for (const auto& row : rows) {
    if (usable(row)) ratios.push_back(row.measured_s / row.predicted_s);
  }
  if (ratios.size() < kMinObservations) return std::nullopt;
  const double centre = median(ratios);
  const double reach =
      std::max(kOutlierSigmas * kMadToSigma * deviation(ratios, centre), kOutlierFloor * centre);
  std::erase_if(ratios, [&](double ratio) { return std::abs(ratio - centre) > reach; });
  if (ratios.size() < kMinObservations) return std::nullopt;

  Correction fit;
  const double factor = median(ratios);
  fit.factor = std::clamp(factor, kMinFactor, kMaxFactor);
  fit.used = ratios.size();
  fit.rejected = rows.size() - ratios.size();
  fit.spread = deviation(ratios, factor) / factor;
  return fit;
}

}  // namespace voidpath::calibrate

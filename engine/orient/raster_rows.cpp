#include "engine/orient/raster_rows.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace voidpath::orient {

namespace {

/// By how much a row may lie off its place, of the way between two. All the way would be in step with no
/// pattern at all, but costs rows that nearly coincide; of half the way differences between rows still tell.
constexpr float kScatter = 0.5F;

/// A number in [0, 1) per row: the fractions of j² times an irrational number are spread evenly whatever
/// multiple of j is added to them (Weyl 1916). Nine bits of it, so that adding the number of a row is exact.
constexpr std::uint32_t kGoldenRatio = 0x9E3779B9;  ///< its fraction times 2^32
constexpr std::uint32_t kRootOfTwo = 0x6A09E667;
float scattered(int j, std::uint32_t irrational) {
  const auto n = static_cast<std::uint32_t>(j);
  return static_cast<float>((n * n * irrational) >> 23) * 0x1p-9F;
}

}  // namespace

void RasterRows::lay(int count) {
  constexpr int kMoreRows = 4;
  y.clear();
  shift.clear();
  for (int j = 0; j < count + kMoreRows; ++j) {
    const float off = j < count ? kScatter * (scattered(j, kGoldenRatio) - 0.5F) : 0.0F;
    y.push_back(static_cast<float>(j) + 0.5F + off);
    shift.push_back(scattered(j, kRootOfTwo));
  }
  auto at = [&](int j) { return j < 0 ? j + 0.5 : static_cast<double>(y[static_cast<std::size_t>(j)]); };
  weight.clear();
  for (int j = 0; j < count; ++j) weight.push_back(0.5 * (at(j + 1) - at(j - 1)));
  thirds.clear();
  for (int j = -kEmptyAround; j < count; ++j) {
    // A divided difference of the third order, scaled.
    std::array<double, 4> factors{};
    double squares = 0;
    for (int k = 0; k < 4; ++k) {
      double product = 1;
      for (int m = 0; m < 4; ++m)
        if (m != k) product *= at(j + k) - at(j + m);
      factors[static_cast<std::size_t>(k)] = 1 / product;
      squares += 1 / (product * product);
    }
    for (double& f : factors) f /= std::sqrt(squares);
    thirds.push_back(factors);
  }
}

}  // namespace voidpath::orient

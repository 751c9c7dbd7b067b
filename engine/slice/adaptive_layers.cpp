#include "engine/slice/adaptive_layers.h"

#include "engine/slice/slope_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace voidpath::slice {

namespace {

/// Heights in steps come from decimal fractions: remainders below this are rounding.
constexpr double kStepSlack = 1e-6;
/// Less surface than this in a layer has no say, mm².
constexpr double kMinProjectedMm2 = 1e-3;
/// Where the surface says nothing, heights are evened out as if this much of it leaned in every layer, mm²
/// of projection per mm of height.
constexpr double kEvennessMm = 1.0;
/// How often the stop token is asked, in points of the lattice.
constexpr std::size_t kCheckEvery = 1024;

struct Cost {
  std::size_t layers = std::numeric_limits<std::size_t>::max();
  double error = 0;
  std::size_t height = 0;  ///< of the last layer, steps
  bool reached() const { return layers != std::numeric_limits<std::size_t>::max(); }
  bool beats(const Cost& other) const {
    return layers != other.layers ? layers < other.layers : error < other.error;
  }
};

bool within(double error_mm, double projected_mm2, double misfit_mm3) {
  return projected_mm2 < kMinProjectedMm2 || misfit_mm3 <= error_mm * projected_mm2;
}

/// The cheapest way to each point of the lattice, in steps above the first layer.
std::vector<Cost> cheapest(const SlopeProfile& slopes, std::size_t points, std::size_t least,
                           std::size_t most, double error_mm, const run::Context& ctx) {
  std::vector<Cost> cost(points + 1);
  cost[0] = {0, 0, 0};
  for (std::size_t from = 0; from < points; ++from) {
    if (from % kCheckEvery == 0) ctx.check();
    if (!cost[from].reached()) continue;
    for (std::size_t height = least; height <= most && from + height <= points; ++height) {
      // The profile's lattice is twice as fine, so that middles of layers lie on it.
      const auto misfit = slopes.misfit(2 * from, 2 * (from + height));
      const bool good = within(error_mm, misfit.slope_mm2, misfit.slope_mm3) &&
                        within(error_mm, misfit.level_mm2, misfit.level_mm3);
      if (!good && height > least) continue;
      const double mm = static_cast<double>(height) * kAdaptiveStepMm;
      const Cost next{cost[from].layers + 1,
                      cost[from].error + misfit.volume_mm3 + 0.25 * kEvennessMm * mm * mm, height};
      if (next.beats(cost[from + height])) cost[from + height] = next;
    }
  }
  return cost;
}

}  // namespace

std::vector<LayerSpan> adaptive_layers(const mesh::TriangleMesh& mesh, const AdaptiveOptions& options,
                                       const run::Context& ctx) {
  const double first = options.first_layer_mm;
  const double low = std::ceil(options.min_mm / kAdaptiveStepMm - kStepSlack);
  const double high = std::floor(options.max_mm / kAdaptiveStepMm + kStepSlack);
  if (!(first > 0) || !(low >= 1) || !(high >= low))
    throw std::invalid_argument("layer heights must be at least 0.01 mm, the least at most the greatest");
  if (mesh.triangles.empty()) return {};
  const double part = mesh::bounds(mesh).max.z();
  if (!(part > 0)) return {};
  const auto least = static_cast<std::size_t>(low);
  const auto most = static_cast<std::size_t>(high);
  std::vector<LayerSpan> spans{{0, first}};
  const double above = (part - first) / kAdaptiveStepMm;
  const double slack = 0.5 * low;
  if (above < slack) return spans;

  const auto points = static_cast<std::size_t>(std::ceil(above + slack));
  const SlopeProfile slopes(mesh, first, 0.5 * kAdaptiveStepMm, 2 * points);
  const std::vector<Cost> cost = cheapest(slopes, points, least, most, options.error_mm, ctx);
  std::size_t end = 0;
  Cost best;
  for (auto i = static_cast<std::size_t>(std::max(0.0, std::floor(above - slack))); i <= points; ++i) {
    if (!cost[i].reached()) continue;
    Cost whole = cost[i];
    whole.error += std::max(0.0, slopes.volume_above_mm3(2 * i));
    if (!whole.beats(best)) continue;
    best = whole;
    end = i;
  }
  std::vector<std::size_t> tops;
  for (std::size_t i = end; i > 0; i -= cost[i].height) tops.push_back(i);
  for (auto top = tops.rbegin(); top != tops.rend(); ++top)
    spans.push_back({spans.back().top_mm, first + static_cast<double>(*top) * kAdaptiveStepMm});
  return spans;
}

}  // namespace voidpath::slice

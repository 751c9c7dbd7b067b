#include "engine/slice/layer_heights.h"

#include <cmath>
#include <stdexcept>

namespace voidpath::slice {

namespace {

/// Heights come from sums of decimal fractions: a remainder this near to half a layer, in layers, is half.
constexpr double kHalfLayerSlack = 1e-6;

}  // namespace

std::vector<LayerSpan> equal_layers(double part_height_mm, double first_layer_mm, double layer_mm) {
  if (!(first_layer_mm > 0) || !(layer_mm > 0))
    throw std::invalid_argument("layer heights must be more than 0 mm");
  if (!(part_height_mm > 0)) return {};
  std::vector<LayerSpan> spans{{0, first_layer_mm}};
  const double above = (part_height_mm - first_layer_mm) / layer_mm;
  const double count = above > 0 ? std::floor(above + 0.5 + kHalfLayerSlack) : 0;
  for (double i = 0; i < count; ++i)
    spans.push_back({spans.back().top_mm, first_layer_mm + (i + 1) * layer_mm});
  return spans;
}

}  // namespace voidpath::slice

#pragma once

#include "engine/slice/layer.h"

#include <vector>

namespace voidpath::slice {

/// Spans of equal height above a first layer of its own. A remainder of less than half a layer at the top
/// is left off, otherwise it gets a whole layer; a part lower than the first layer gets one layer.
std::vector<LayerSpan> equal_layers(double part_height_mm, double first_layer_mm, double layer_mm);

}  // namespace voidpath::slice

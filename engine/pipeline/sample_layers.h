#pragma once

#include "engine/slice/layer.h"
#include "engine/toolpath/build.h"
#include "engine/toolpath/settings.h"

#include <cstddef>
#include <vector>

/// Which layers to plan when only the time of a print is asked for. Neighbours are mostly alike: a layer can
/// stand for those around it, and where areas jump, layers are looked at one by one.
namespace voidpath::pipeline {

/// Seconds each layer would take at constant speeds, from areas and outlines alone: no booleans. Far from the
/// true time, but nearly in proportion to it from one layer to the next.
std::vector<double> rough_seconds(const slice::LayerStack& stack, const toolpath::PrintSettings& settings);

/// Groups of layers, at most `most` of them (3 at least), that cover the stack, cut where rough time, outline
/// and number of regions change most. The first layer is a group by itself. Samples lie near the middle and
/// are by turns of even and odd number, so that both directions of infill are met.
std::vector<toolpath::LayerGroup> choose_samples(const slice::LayerStack& stack,
                                                 const toolpath::PrintSettings& settings, std::size_t most);

}  // namespace voidpath::pipeline

#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// What is to be held, and where support may not be: the same for every style of support. By layer.
struct SupportTask {
  /// Areas whose top holds what hangs over them, the z gap above, and reaches a little beyond it.
  std::vector<geom::Regions> contact;
  /// Beside the part by the xy gap, and over and under it by the z gap.
  std::vector<geom::Regions> forbidden;
  bool empty() const { return contact.empty(); }
};

/// Overhangs that lean out more than the settings' angle and that nothing bridges. Without any: empty.
SupportTask find_support_task(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces,
                              const SliceSettings& settings, const run::Context& ctx);

/// The highest layer whose top keeps the z gap below the bottom of layer i; none: stack.size().
std::size_t layer_below_gap(const slice::LayerStack& stack, std::size_t i, double z_gap_mm);

}  // namespace voidpath::toolpath

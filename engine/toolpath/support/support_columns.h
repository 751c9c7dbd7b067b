#pragma once

#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/support_task.h"
#include "engine/toolpath/support/supports.h"

#include <vector>

namespace voidpath::toolpath {

/// Straight down from every contact, as far as there is room; the top layers are dense. Going up, a column
/// leans out over what is beside it no further than the part may.
std::vector<SupportAreas> support_columns(const slice::LayerStack& stack, const SupportTask& task,
                                          const SliceSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/run/context.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support_task.h"
#include "engine/toolpath/supports.h"

#include <vector>

namespace voidpath::toolpath {

/// Straight down from every contact, as far as there is room; the top layers are dense.
std::vector<SupportAreas> support_columns(const SupportTask& task, const SliceSettings& settings,
                                          const run::Context& ctx);

}  // namespace voidpath::toolpath

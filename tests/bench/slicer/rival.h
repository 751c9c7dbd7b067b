#pragma once

#include "engine/toolpath/settings.h"

#include <string>

namespace voidpath::bench {

/// Our settings as a PrusaSlicer 2.5 configuration: the same layers, widths, walls, skins, infill, support
/// rule, speeds, cooling and retraction. What has no counterpart in ours is switched off.
std::string prusa_config(const toolpath::PrintSettings& settings);

}  // namespace voidpath::bench

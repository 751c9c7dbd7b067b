#pragma once

#include "firmware-io/event.h"

#include <string>
#include <vector>

namespace voidpath::fw {

/// Marlin knows no more.
inline constexpr int kMostExtruders = 8;

/// What leaves a printer cold, line by line: each of its hotends, whichever is at work.
std::vector<std::string> heaters_off(const FirmwareInfo& firmware);

}  // namespace voidpath::fw

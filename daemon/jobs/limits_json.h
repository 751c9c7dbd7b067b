#pragma once

#include "firmware-io/firmware_limits.h"

#include <string>

namespace voidpath::daemon {

/// As kept in the store; what the firmware did not say is left out. Reading ignores what it does not know.
/// Throws JsonError for broken text.
std::string to_text(const fw::FirmwareLimits& limits);
fw::FirmwareLimits limits_from(const std::string& text);

}  // namespace voidpath::daemon

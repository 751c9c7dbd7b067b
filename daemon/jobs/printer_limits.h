#pragma once

#include "config/config.h"
#include "firmware-io/firmware_limits.h"

#include <string>
#include <vector>

/// What a printer's firmware says of itself, laid over the profile that was written for it.
namespace voidpath::daemon {

/// Where the firmware's word differs from the profile's, a sentence each, for the user: "print acceleration:
/// the printer says 800 mm/s², its profile 1000". Values that agree but for the rounding of what firmware
/// prints count as equal. An axis that reaches further than the bed is no difference.
std::vector<std::string> differences(const config::Profile& profile, const fw::FirmwareLimits& firmware);

/// The profile with the firmware's values in it. Room is only ever taken away: software endstops tell how far
/// axes reach, not how large the bed is. Where anything differs, sha256 is another, so that corrections
/// learned for other values do not count.
config::Profile with_limits(config::Profile profile, const fw::FirmwareLimits& firmware);

/// The limits that times are predicted with, in one line.
std::string limits_text(const config::Profile& profile);

}  // namespace voidpath::daemon

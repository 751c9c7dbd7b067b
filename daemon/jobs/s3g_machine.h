#pragma once

#include "config/config.h"
#include "firmware-io/s3g/machine.h"

namespace voidpath::daemon {

/// The axes of a profile whose firmware is s3g. Both extruders have the one's steps and speed.
fw::s3g::Machine s3g_machine(const config::Profile& profile);

}  // namespace voidpath::daemon

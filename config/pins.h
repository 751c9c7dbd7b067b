#pragma once

#include "config/config.h"
#include "config/fields.h"

namespace voidpath::config {

/// The keys below a printer's `pins:`. Throws ConfigError.
void read_pins(Reader& r, PinsConfig& pins);

}  // namespace voidpath::config

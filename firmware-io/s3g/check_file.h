#pragma once

#include "firmware-io/line_source.h"
#include "firmware-io/s3g/machine.h"

#include <stop_token>

namespace voidpath::fw::s3g {

/// Encodes a whole file to nothing: what a print over the wire would refuse hours later is refused now.
/// Throws EncodeError, naming the first line that cannot be carried out as meant; what the source throws.
/// Ends early, and says nothing, when asked to stop.
void check_file(LineSource& gcode, const Machine& machine, const std::stop_token& stop);

}  // namespace voidpath::fw::s3g

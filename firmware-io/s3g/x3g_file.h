#pragma once

#include "firmware-io/line_source.h"
#include "firmware-io/s3g/machine.h"

#include <ostream>
#include <string>
#include <vector>

namespace voidpath::fw::s3g {

/// Writes G-code as what a MakerBot reads from its card (.x3g): the payloads that a print over the wire would
/// send, one behind the other. What a host would do itself the printer is asked to do: a pause (M0, M600)
/// waits for its button.
/// Returns what was left out, in words, each once. Throws EncodeError, naming the line, for what cannot be
/// carried out as meant; what the source throws; std::runtime_error when `out` takes no more.
std::vector<std::string> write_x3g(LineSource& gcode, const Machine& machine, const std::string& name,
                                   std::ostream& out);

}  // namespace voidpath::fw::s3g

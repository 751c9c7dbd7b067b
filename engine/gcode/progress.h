#pragma once

#include "engine/motion/limits.h"
#include "engine/run/context.h"

#include <iosfwd>

namespace voidpath::gcode {

/// Copies G-code and puts `M73 P<percent> R<minutes>` in wherever one of the two changes, by the planner's
/// own times: percent of the time done, minutes left rounded up. The first stands before the first motion
/// (P0), the last after the last (P100 R0). `in` is read twice and must be seekable. Memory is bounded by the
/// number of changes. Throws std::runtime_error if a stream fails; run::Stopped.
void add_progress(std::istream& in, std::ostream& out, const motion::MachineLimits& limits,
                  const run::Context& ctx = {});

}  // namespace voidpath::gcode

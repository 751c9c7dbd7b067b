#pragma once

#include "engine/motion/limits.h"
#include "engine/run/context.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <cstddef>
#include <iosfwd>
#include <string>

namespace voidpath::toolpath {

struct EmitStats {
  std::size_t layers = 0;
  double filament_mm = 0;
  double extruded_mm3 = 0;
  double travel_mm = 0;
  std::size_t retractions = 0;
};

/// Writes the plan as G-code: header comments, the printer's start G-code, per layer `;LAYER_CHANGE`,
/// `;Z:<mm>`, `;TYPE:<name>`, travels with retraction, extrusion, fan, temperatures, the end G-code.
/// `header` is written as comment lines on top. Numbers never depend on the locale.
/// `limits`: the printer's, by which layers are timed that may need slowing down.
/// Throws std::runtime_error for an unknown placeholder in start or end G-code, naming it.
EmitStats emit(const Plan& plan, const PrintSettings& settings, const std::string& header, std::ostream& out,
               const motion::MachineLimits& limits, const run::Context& ctx = {});

}  // namespace voidpath::toolpath

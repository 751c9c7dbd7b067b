#pragma once

#include "engine/pipeline/prepare.h"

/// What is asked of G-code that another program made of our placed part.
namespace voidpath::pipeline {

/// Throws std::runtime_error when the file prints nothing, prints outside of the machine, or has the part
/// elsewhere than it was placed.
void check_foreign(const std::filesystem::path& gcode, const PlacedPart& part,
                   const gcode::Estimate& estimate);

/// What our emitter would count, from the file alone.
toolpath::EmitStats foreign_stats(const gcode::Estimate& estimate, const toolpath::PrintSettings& print);

}  // namespace voidpath::pipeline

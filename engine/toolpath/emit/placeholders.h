#pragma once

#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <map>
#include <string>
#include <string_view>

namespace voidpath::toolpath {

/// Placeholders of start and end G-code: a name in braces is replaced by its value.
///
/// From the profile:
///   {nozzle_c} {nozzle_first_layer_c} {bed_c} {bed_first_layer_c}   temperatures, °C
///   {filament} {filament_diameter}                                  name; mm
///   {printer} {nozzle_mm} {bed_x} {bed_y} {height}                  name; mm
///   {layer_height} {first_layer_height} {line_width}                mm
///   {perimeters} {infill_density}                                   count; 0 to 1
///   {travel_speed} {first_layer_speed}                              mm/s
///   {travel_feed} {first_layer_feed}                                mm/min, as F words want it
///   {retract_length} {retract_speed} {retract_feed}                 mm, mm/s, mm/min
/// From the print:
///   {layer_count} {max_z}                                           layers; mm
///   {first_layer_min_x} {first_layer_min_y} {first_layer_max_x} {first_layer_max_y}
///   {first_layer_size_x} {first_layer_size_y}    area of the first layer's beads, mm
///   {min_x} {min_y} {max_x} {max_y}              area of all layers' beads, mm
using Placeholders = std::map<std::string, std::string, std::less<>>;

Placeholders placeholders(const Plan& plan, const PrintSettings& settings);

/// Replaces {name} by its value; {{ and }} stand for single braces. A lone { or } that does not enclose a
/// name is kept as it is. Throws std::runtime_error for an unknown name, naming it and `what`.
std::string expand(std::string_view text, const Placeholders& values, std::string_view what);

}  // namespace voidpath::toolpath

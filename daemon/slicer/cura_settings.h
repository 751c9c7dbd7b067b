#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/toolpath/settings.h"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// CuraEngine's settings. It takes the `default_value` of each from a definition and computes none of the
/// formulas Cura itself computes, so every one that matters is named.
namespace voidpath::daemon {

using CuraSettings = std::map<std::string, std::string>;

/// Our settings in CuraEngine's words: the same layers, widths, walls, skins, infill, supports, speeds,
/// accelerations, retraction, cooling and temperatures.
CuraSettings cura_settings(const toolpath::PrintSettings& print);

/// Our printer's start and end G-code, with the placeholders filled from `settings` where they know the
/// value, and with the first layer's area taken for the part's footprint. Throws std::runtime_error naming an
/// unknown placeholder.
CuraSettings cura_start_and_end(const toolpath::PrintSettings& print, const CuraSettings& settings,
                                const mesh::Bounds& placed);

/// The settings as arguments of CuraEngine: once for everything, and once for the extruder, whose own definition
/// stands nearer to the print.
std::vector<std::string> cura_arguments(const CuraSettings& settings);

/// Lines of `key = value`; sections in brackets, empty lines and those beginning with # or ; are passed over,
/// but for a profile of Cura's (with a section [values]), of which only that section counts. An indented line
/// goes on with the value above; \n in a value is a new line. Throws config::ConfigError for anything else
/// and for a formula ("= ..."): nothing here can compute it.
CuraSettings read_cura_settings(const std::filesystem::path& file);

}  // namespace voidpath::daemon

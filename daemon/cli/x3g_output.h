#pragma once

#include "config/config.h"

#include <filesystem>
#include <string>
#include <vector>

namespace voidpath::cli {

bool is_x3g_name(const std::filesystem::path& file);

/// Turns the G-code at `gcode` into `out`, by way of a file beside that; `gcode` is removed either way.
/// Returns what was left out, in words. Throws std::runtime_error; then nothing has changed at `out`.
std::vector<std::string> convert_to_x3g(const std::filesystem::path& gcode, const std::filesystem::path& out,
                                        const config::Profile& profile);

}  // namespace voidpath::cli

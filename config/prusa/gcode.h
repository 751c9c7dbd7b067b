#pragma once

#include "config/prusa/ini.h"

#include <string>
#include <vector>

namespace voidpath::config {

struct TranslatedGcode {
  std::string text;                    ///< with our placeholders; each line ends with a new line
  std::vector<std::string> left_out;   ///< lines that stand in `text` as comments only
  std::vector<std::string> constants;  ///< "name = value": resolved to what the file says
};

/// PrusaSlicer's start or end G-code ([name], {name}, {name[0]}) in our placeholders. What we have no word
/// for is replaced by the file's own value; a line with an expression, a condition or a name that neither
/// knows is left out, whole, as is everything between {if} and {endif}.
TranslatedGcode translate_gcode(const std::string& gcode, const IniValues& values);

}  // namespace voidpath::config

#pragma once

#include "config/prusa/ini.h"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::config {

/// A PrusaSlicer configuration in our words, and what became of the rest of it.
struct PrusaImport {
  /// "section.key" and value as YAML, in the order of the profile's keys.
  std::vector<std::pair<std::string, std::string>> values;
  std::vector<std::string> approximated;  ///< came over, but not exactly: a sentence each
  std::vector<std::string> left_out;      ///< "key = value": has an effect there and none here
  std::vector<std::string> kept;          ///< our keys that the file says nothing of; the base's values stand
  std::vector<std::string> notes;
};

/// Percentages, automatic widths and values that lean on others are resolved as PrusaSlicer 2.5 does it. A
/// key that is not in the file, though PrusaSlicer writes it, is not assumed: the base's value stands and is
/// told of. Throws ConfigError for a value that cannot be read.
PrusaImport import_prusa(const IniValues& values);

/// Whether a value leaves a print as it is: what need not be listed when it cannot be carried over. `key` is
/// one that import_prusa() has no use for.
bool is_neutral(const std::string& key, const std::string& value);

/// The profile as YAML: `base` names the printer profile that says what the file does not.
/// parts: which of our three kinds, "printer", "material", "quality"; empty: all in one, complete by itself.
std::string profile_yaml(const PrusaImport& import, const std::string& part, const std::string& base,
                         const std::string& description);

}  // namespace voidpath::config

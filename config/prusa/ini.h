#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// What PrusaSlicer writes: a configuration (File > Export > Export Config), a bundle of presets, and the
/// block of
/// `; key = value` lines at the end of its G-code.
namespace voidpath::config {

using IniValues = std::map<std::string, std::string>;

struct IniSection {
  std::string kind;  ///< "print", "filament", "printer"; empty: a whole configuration
  std::string name;
  IniValues values;
};

struct PrusaFile {
  std::vector<IniSection> sections;
  IniValues presets;  ///< a bundle's [presets]: which of each kind was in use
};

/// Throws ConfigError, also when the file holds no setting at all.
PrusaFile read_prusa_file(const std::filesystem::path& file);

/// Names of the presets of a kind that can be chosen; those in asterisks are only inherited from.
std::vector<std::string> preset_names(const PrusaFile& file, const std::string& kind);

/// One configuration out of the file; `inherits` are followed within it. Of a bundle, the presets named, else
/// the only ones, else those that were in use. What was decided, and what is inherited from presets that the
/// file does not hold, goes to `notes`. Throws ConfigError naming the choices where there are several.
struct PresetNames {
  std::string print;
  std::string filament;
  std::string printer;
};
IniValues choose_presets(const PrusaFile& file, const PresetNames& names, std::vector<std::string>& notes);

/// The inverse of PrusaSlicer's escapes: \n, \r, \\, \".
std::string unescaped(const std::string& value);
/// Parts of a list of texts: "...";"...".
std::vector<std::string> text_list(const std::string& value);

}  // namespace voidpath::config

#include "config/prusa/ini.h"

#include "config/config.h"
#include "config/fields.h"

#include <algorithm>
#include <fstream>
#include <set>

namespace voidpath::config {

namespace {

/// A preset that inherits from itself is caught by this depth.
constexpr int kMaxInherits = 16;

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t\r");
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

bool is_key(const std::string& text) {
  return !text.empty() &&
         text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_#*:") ==
             std::string::npos;
}

/// "key = value" into the map; false when the line is none.
bool take(const std::string& line, IniValues& out) {
  const std::size_t equals = line.find('=');
  if (equals == std::string::npos) return false;
  const std::string key = trimmed(line.substr(0, equals));
  if (!is_key(key)) return false;
  out[key] = trimmed(line.substr(equals + 1));
  return true;
}

/// The lines between the marks that PrusaSlicer puts, or, of older ones, the comments at the very end.
IniValues block_of_gcode(std::istream& in) {
  IniValues marked, running;
  bool between = false, complete = false;
  std::string line;
  while (std::getline(in, line)) {
    const std::string text = trimmed(line);
    if (text.empty()) continue;
    if (text.front() != ';') {
      running.clear();
      continue;
    }
    const std::string said = trimmed(text.substr(1));
    if (said == "prusaslicer_config = begin" || said == "config = begin") {
      between = true;
      marked.clear();
    } else if (said == "prusaslicer_config = end" || said == "config = end") {
      complete = complete || between;
      between = false;
    } else {
      take(said, between ? marked : running);
    }
  }
  return complete ? marked : running;
}

bool is_gcode_name(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".gcode" || extension == ".gco" || extension == ".g" || extension == ".gx";
}

PrusaFile read_ini(std::istream& in, const std::string& file) {
  PrusaFile out;
  IniSection* section = nullptr;
  IniValues whole, other;
  IniValues* values = &whole;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    const std::string text = trimmed(line);
    if (text.empty() || text.front() == '#' || text.front() == ';') continue;
    if (text.front() == '[' && text.back() == ']') {
      const std::string head = text.substr(1, text.size() - 2);
      const std::size_t colon = head.find(':');
      const std::string kind = head.substr(0, colon);
      if (head == "presets") {
        values = &out.presets;
      } else if (colon != std::string::npos && (kind == "print" || kind == "filament" || kind == "printer")) {
        section = &out.sections.emplace_back(IniSection{kind, trimmed(head.substr(colon + 1)), {}});
        values = &section->values;
      } else {
        values = &other;  // vendor, printer models, resin presets: nothing that we print with
      }
      continue;
    }
    if (!take(text, *values))
      throw ConfigError(file + ":" + std::to_string(number) + ": 'key = value' is wanted");
  }
  if (!whole.empty()) out.sections.push_back({"", "", std::move(whole)});
  return out;
}

const IniSection* find(const PrusaFile& file, const std::string& kind, const std::string& name) {
  for (const IniSection& s : file.sections)
    if (s.kind == kind && s.name == name) return &s;
  return nullptr;
}

/// The preset over what it inherits, the last one named winning, as PrusaSlicer lays them.
IniValues resolved(const PrusaFile& file, const IniSection& section, int depth,
                   std::vector<std::string>& notes) {
  if (depth > kMaxInherits)
    throw ConfigError("preset " + section.name + ": its 'inherits' leads back to itself");
  IniValues out;
  const auto inherits = section.values.find("inherits");
  if (inherits != section.values.end()) {
    std::string rest = inherits->second;
    while (!trimmed(rest).empty()) {
      const std::size_t semicolon = std::min(rest.find(';'), rest.size());
      std::string name = trimmed(rest.substr(0, semicolon));
      if (name.size() > 1 && name.front() == '"' && name.back() == '"')
        name = name.substr(1, name.size() - 2);
      rest = semicolon < rest.size() ? rest.substr(semicolon + 1) : "";
      if (const IniSection* base = find(file, section.kind, name)) {
        for (const auto& [key, value] : resolved(file, *base, depth + 1, notes)) out[key] = value;
      } else if (!name.empty()) {
        notes.push_back("the " + section.kind + " preset " + section.name + " inherits from " + name +
                        ", which the file does not hold: only what stands in the file came over");
      }
    }
  }
  for (const auto& [key, value] : section.values)
    if (key != "inherits") out[key] = value;
  return out;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + ("\"" + name + "\"");
  return out;
}

std::string choose(const PrusaFile& file, const std::string& kind, const std::string& wanted,
                   std::vector<std::string>& notes) {
  const std::vector<std::string> names = preset_names(file, kind);
  if (!wanted.empty()) {
    if (find(file, kind, wanted) != nullptr) return wanted;
    const std::string near = nearest(wanted, names);
    throw ConfigError("there is no " + kind + " preset \"" + wanted + "\"" +
                      (near.empty() ? "" : "; did you mean \"" + near + "\"?") +
                      " The file holds: " + list_of(names));
  }
  if (names.empty()) return "";
  std::string chosen = names.size() == 1 ? names.front() : "";
  if (const auto used = file.presets.find(kind);
      chosen.empty() && used != file.presets.end() && find(file, kind, used->second) != nullptr)
    chosen = used->second;
  if (chosen.empty())
    throw ConfigError("the file holds several " + kind + " presets; choose with --" + kind +
                      " NAME: " + list_of(names));
  notes.push_back(kind + " preset: " + chosen);
  return chosen;
}

}  // namespace

PrusaFile read_prusa_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw ConfigError(file.string() + ": cannot be read");
  PrusaFile out;
  if (is_gcode_name(file)) {
    IniValues values = block_of_gcode(in);
    if (!values.empty()) out.sections.push_back({"", "", std::move(values)});
  } else {
    out = read_ini(in, file.string());
  }
  if (out.sections.empty())
    throw ConfigError(file.string() +
                      ": no PrusaSlicer settings in it; export them with File > Export > Export Config");
  return out;
}

std::vector<std::string> preset_names(const PrusaFile& file, const std::string& kind) {
  std::vector<std::string> out;
  for (const IniSection& s : file.sections)
    if (s.kind == kind && !s.name.starts_with('*')) out.push_back(s.name);
  return out;
}

IniValues choose_presets(const PrusaFile& file, const PresetNames& names, std::vector<std::string>& notes) {
  IniValues out;
  for (const IniSection& s : file.sections)
    if (s.kind.empty())
      for (const auto& [key, value] : s.values) out[key] = value;
  for (const auto& [kind, wanted] :
       {std::pair{"printer", names.printer}, {"filament", names.filament}, {"print", names.print}}) {
    const std::string name = choose(file, kind, wanted, notes);
    if (name.empty()) continue;
    for (const auto& [key, value] : resolved(file, *find(file, kind, name), 0, notes)) out[key] = value;
    out[std::string(kind) + "_settings_id"] = name;
  }
  return out;
}

std::string unescaped(const std::string& value) {
  std::string out;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (value[i] != '\\' || i + 1 == value.size()) {
      out += value[i];
      continue;
    }
    const char c = value[++i];
    if (c == 'n')
      out += '\n';
    else if (c != 'r')
      out += c;
  }
  return out;
}

std::vector<std::string> text_list(const std::string& value) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < value.size();) {
    std::string part;
    if (value[i] == '"') {
      for (++i; i < value.size() && value[i] != '"'; ++i) {
        part += value[i];
        if (value[i] == '\\' && i + 1 < value.size()) part += value[++i];
      }
      ++i;
    } else {
      const std::size_t end = std::min(value.find(';', i), value.size());
      part = trimmed(value.substr(i, end - i));
      i = end;
    }
    out.push_back(unescaped(part));
    i = std::min(value.find(';', i), value.size());
    if (i < value.size()) ++i;
  }
  return out;
}

}  // namespace voidpath::config

#include "config/prusa/gcode.h"

#include <algorithm>
#include <map>
#include <optional>

namespace voidpath::config {

namespace {

/// PrusaSlicer's name (without index) and ours; of what has two axes, index 0 is x and 1 is y.
const std::map<std::string, std::string> kNames = {{"first_layer_temperature", "nozzle_first_layer_c"},
                                                   {"temperature", "nozzle_c"},
                                                   {"first_layer_bed_temperature", "bed_first_layer_c"},
                                                   {"bed_temperature", "bed_c"},
                                                   {"filament_type", "filament"},
                                                   {"filament_diameter", "filament_diameter"},
                                                   {"nozzle_diameter", "nozzle_mm"},
                                                   {"layer_height", "layer_height"},
                                                   {"max_print_height", "height"},
                                                   {"perimeters", "perimeters"},
                                                   {"travel_speed", "travel_speed"},
                                                   {"retract_length", "retract_length"},
                                                   {"retract_speed", "retract_speed"},
                                                   {"printer_model", "printer"},
                                                   {"total_layer_count", "layer_count"},
                                                   {"max_layer_z", "max_z"},
                                                   {"first_layer_print_min", "first_layer_min_"},
                                                   {"first_layer_print_max", "first_layer_max_"},
                                                   {"first_layer_print_size", "first_layer_size_"},
                                                   {"print_bed_max", "bed_"},
                                                   {"print_bed_size", "bed_"}};

bool is_word(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

struct Name {
  std::string word;
  std::size_t index = 0;
};

/// "name", "name[0]", "name[initial_tool]" (one extruder: the first), and the old "name_0".
std::optional<Name> name_in(const std::string& text, const IniValues& values) {
  Name name{text, 0};
  if (const std::size_t open = text.find('['); open != std::string::npos) {
    if (text.back() != ']') return std::nullopt;
    const std::string index = text.substr(open + 1, text.size() - open - 2);
    name.word = text.substr(0, open);
    if (index.size() == 1 && index[0] >= '0' && index[0] <= '9')
      name.index = static_cast<std::size_t>(index[0] - '0');
    else if (index != "initial_tool" && index != "initial_extruder" && index != "current_extruder")
      return std::nullopt;
  } else if (text.size() > 2 && text[text.size() - 2] == '_' && text.back() >= '0' && text.back() <= '9' &&
             !values.contains(text)) {
    name = {text.substr(0, text.size() - 2), static_cast<std::size_t>(text.back() - '0')};
  }
  if (!is_word(name.word)) return std::nullopt;
  return name;
}

class Translator {
 public:
  explicit Translator(const IniValues& values) : values_(values) {}

  TranslatedGcode run(const std::string& gcode) {
    for (std::size_t begin = 0; begin < gcode.size();) {
      const std::size_t end = std::min(gcode.find('\n', begin), gcode.size());
      std::string line = gcode.substr(begin, end - begin);
      if (!line.empty() && line.back() == '\r') line.pop_back();
      take(line);
      begin = end + 1;
    }
    return std::move(out_);
  }

 private:
  void take(const std::string& line) {
    const int before = depth_;
    for (std::size_t at = 0; (at = line.find('{', at)) != std::string::npos; ++at) {
      if (line.compare(at, 3, "{if") == 0) ++depth_;
      if (line.compare(at, 6, "{endif") == 0 && depth_ > 0) --depth_;
    }
    if (before > 0 || depth_ > 0 || line.find("{if") != std::string::npos) return leave_out(line);
    const std::size_t semicolon = std::min(line.find(';'), line.size());
    const std::optional<std::string> code = replaced(line.substr(0, semicolon));
    if (!code) return leave_out(line);
    out_.text += *code + harmless(line.substr(semicolon)) + "\n";
  }

  void leave_out(const std::string& line) {
    if (line.find_first_not_of(" \t") == std::string::npos) return;
    out_.left_out.push_back(line);
    out_.text += harmless("; not carried over: " + line) + "\n";
  }

  /// In a comment braces mean nothing.
  static std::string harmless(const std::string& comment) {
    std::string out;
    for (const char c : comment) {
      out += c;
      if (c == '{' || c == '}') out += c;
    }
    return out;
  }

  std::optional<std::string> replaced(const std::string& code) {
    std::string out;
    for (std::size_t i = 0; i < code.size(); ++i) {
      const char open = code[i];
      if (open != '{' && open != '[') {
        if (open == '}') return std::nullopt;
        out += open;
        continue;
      }
      const std::size_t end = closing(code, i);
      if (end == std::string::npos) return std::nullopt;
      const std::optional<std::string> value = value_of(code.substr(i + 1, end - i - 1));
      if (!value) return std::nullopt;
      out += *value;
      i = end;
    }
    return out;
  }

  /// The bracket that closes the one at `open`; an index inside braces has brackets of its own.
  static std::size_t closing(const std::string& code, std::size_t open) {
    if (code[open] == '{') return code.find('}', open);
    return code.find(']', open);
  }

  std::optional<std::string> value_of(const std::string& text) {
    const std::optional<Name> name = name_in(text, values_);
    if (!name) return std::nullopt;
    if (const auto ours = kNames.find(name->word); ours != kNames.end()) {
      if (!ours->second.ends_with('_')) return "{" + ours->second + "}";
      if (name->index > 1) return std::nullopt;
      return "{" + ours->second + (name->index == 0 ? "x}" : "y}");
    }
    if (name->word == "first_layer_height") return "{first_layer_height}";
    if (name->word == "initial_tool" || name->word == "initial_extruder" || name->word == "current_extruder")
      return "0";
    const auto found = values_.find(name->word);
    if (found == values_.end()) return std::nullopt;
    return constant(*name, found->second);
  }

  std::optional<std::string> constant(const Name& name, const std::string& all) {
    std::string rest = all;
    for (std::size_t i = 0; i < name.index && rest.find(',') != std::string::npos; ++i)
      rest = rest.substr(rest.find(',') + 1);
    const std::string value = rest.substr(0, rest.find(','));
    // Only plain values can stand in a command.
    if (value.empty() || value.find_first_of("\\\"{}[]; ") != std::string::npos) return std::nullopt;
    const std::string said = name.word + " = " + value;
    if (std::find(out_.constants.begin(), out_.constants.end(), said) == out_.constants.end())
      out_.constants.push_back(said);
    return value;
  }

  const IniValues& values_;
  TranslatedGcode out_;
  int depth_ = 0;
};

}  // namespace

TranslatedGcode translate_gcode(const std::string& gcode, const IniValues& values) {
  return Translator(values).run(gcode);
}

}  // namespace voidpath::config

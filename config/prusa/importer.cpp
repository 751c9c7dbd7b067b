#include "config/prusa/importer.h"

#include "config/config.h"
#include "config/fields.h"
#include "config/tree.h"

#include <algorithm>
#include <cmath>

namespace voidpath::config {

namespace {

/// Where each section of ours belongs when the import is written as three profiles.
const std::pair<const char*, const char*> kParts[] = {
    {"machine", "printer"},  {"gcode", "printer"}, {"retract", "printer"}, {"filament", "material"},
    {"cooling", "material"}, {"slice", "quality"}, {"speed", "quality"},   {"acceleration", "quality"}};

std::string section_of(const std::string& key) { return key.substr(0, key.find('.')); }
std::string name_of(const std::string& key) { return key.substr(key.find('.') + 1); }

std::string first_of(const std::string& list) {
  // PrusaSlicer reads the number and not what is said about it behind a #.
  const std::string value = list.substr(0, std::min(list.find(','), list.find(" #")));
  const std::size_t end = value.find_last_not_of(' ');
  return end == std::string::npos ? "" : value.substr(0, end + 1);
}

}  // namespace

std::string millimetres(double value) { return number_text(std::round(value * 1e4) / 1e4) + " mm"; }

PrusaImporter::PrusaImporter(const IniValues& values) : values_(values) {
  const Tree tree = read_yaml_text(profile_text(Profile{}), "profile");
  for (const Tree::Entry& section : tree.map)
    for (const Tree::Entry& entry : section.value.map) {
      order_.push_back(section.key + "." + entry.key);
      // Printed only where it is set.
      if (order_.back() == "machine.junction_deviation_mm") order_.emplace_back("machine.jerk_mm_s");
    }
  schema_.insert(order_.begin(), order_.end());
}

void PrusaImporter::fail(const std::string& key, const std::string& why) const {
  throw ConfigError(key + " = " + values_.at(key) + ": " + why);
}

std::optional<std::string> PrusaImporter::word(const std::string& key) {
  use(key);
  const auto found = values_.find(key);
  if (found == values_.end() || found->second == "nil" || found->second.empty()) return std::nullopt;
  return found->second;
}

std::optional<PrusaImporter::Amount> PrusaImporter::amount(const std::string& key) {
  const std::optional<std::string> all = word(key);
  if (!all) return std::nullopt;
  std::string text = first_of(*all);
  if (text == "nil") return std::nullopt;
  Amount out;
  out.percent = text.ends_with('%');
  if (out.percent) text.pop_back();
  try {
    out.value = parse_number(text);
  } catch (const std::invalid_argument& e) {
    fail(key, e.what());
  }
  return out;
}

std::optional<double> PrusaImporter::number(const std::string& key) {
  const auto value = amount(key);
  if (!value) return std::nullopt;
  if (value->percent) fail(key, "a number is wanted, not a share");
  return value->value;
}

std::optional<double> PrusaImporter::part_of(const std::string& key, std::optional<double> whole) {
  const auto value = amount(key);
  if (!value || (value->percent && !whole)) return std::nullopt;
  return value->of(whole.value_or(0));
}

std::optional<bool> PrusaImporter::flag(const std::string& key) {
  const auto value = number(key);
  if (!value) return std::nullopt;
  return *value != 0;
}

bool PrusaImporter::put_yaml(const std::string& ours, const std::string& yaml) {
  if (!known(ours)) return false;
  std::erase_if(out_.values, [&](const auto& pair) { return pair.first == ours; });
  out_.values.emplace_back(ours, yaml);
  return true;
}

bool PrusaImporter::put(const std::string& ours, std::optional<double> value) {
  // Sums and shares of decimals: what a micrometre's thousandth does not see is no digit of the user's.
  return value && put_yaml(ours, number_text(std::round(*value * 1e6) / 1e6));
}

bool PrusaImporter::put_flag(const std::string& ours, std::optional<bool> value) {
  return value && put_yaml(ours, *value ? "true" : "false");
}

bool PrusaImporter::put_text(const std::string& ours, const std::string& value) {
  if (value.find('\n') == std::string::npos) return put_yaml(ours, yaml_scalar(value));
  std::string block = "|";
  for (std::size_t begin = 0; begin < value.size();) {
    const std::size_t end = std::min(value.find('\n', begin), value.size());
    block += "\n    " + value.substr(begin, end - begin);
    begin = end + 1;
  }
  return put_yaml(ours, block);
}

PrusaImport PrusaImporter::finish() {
  const auto place = [&](const std::string& key) {
    return std::find(order_.begin(), order_.end(), key) - order_.begin();
  };
  std::stable_sort(out_.values.begin(), out_.values.end(),
                   [&](const auto& a, const auto& b) { return place(a.first) < place(b.first); });
  for (const auto& [key, value] : values_)
    if (!used_.contains(key) && !is_neutral(key, value)) out_.left_out.push_back(key + " = " + value);
  for (const std::string& key : order_)
    if (std::none_of(out_.values.begin(), out_.values.end(), [&](const auto& v) { return v.first == key; }))
      out_.kept.push_back(key);
  return std::move(out_);
}

PrusaImport import_prusa(const IniValues& values) {
  PrusaImporter in(values);
  if (const auto technology = in.word("printer_technology"); technology && *technology != "FFF")
    throw ConfigError("printer_technology = " + *technology + ": only printers of filament are known here");
  const PrusaLayers layers = import_layers(in);
  import_shells(in, layers);
  import_supports(in, layers);
  import_speeds(in);
  import_filament(in);
  import_machine(in);
  return in.finish();
}

std::string profile_yaml(const PrusaImport& import, const std::string& part, const std::string& base,
                         const std::string& description) {
  std::string out = "description: " + yaml_scalar(description) + "\n";
  if (part.empty() || part == "printer") out += "base: " + yaml_scalar(base) + "\n";
  if (part.empty()) out += "complete: true\n";
  std::string open;
  for (const auto& [key, value] : import.values) {
    const std::string section = section_of(key);
    const auto belongs =
        std::find_if(std::begin(kParts), std::end(kParts), [&](const auto& p) { return section == p.first; });
    if (!part.empty() && (belongs == std::end(kParts) || part != belongs->second)) continue;
    if (section != open) out += section + ":\n";
    open = section;
    out += "  " + name_of(key) + ": " + value + "\n";
  }
  return out;
}

}  // namespace voidpath::config

#include "firmware-io/marlin/settings.h"

#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

namespace voidpath::fw::marlin {
namespace {

constexpr double kMmPerInch = 25.4;
constexpr double kMicrosecond = 1e-6;
constexpr std::string_view kAxisLetters = "XYZE";

std::string_view without_blanks_before(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text;
}

std::optional<double> leading_number(std::string_view text) {
  text = without_blanks_before(text);
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || !std::isfinite(value)) return {};
  return value;
}

// The number behind a letter that begins a word: 93 of E in "M92 X80 E93".
std::optional<double> word_value(std::string_view command, char letter) {
  for (std::size_t i = 1; i + 1 < command.size(); ++i)
    if (command[i] == letter && command[i - 1] == ' ') return leading_number(command.substr(i + 1));
  return {};
}

// Prusa's firmware tells its values for the normal and then those for the silent mode: the first counts.
void take_axes(std::string_view command, PerAxis& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!values[i]) values[i] = word_value(command, kAxisLetters[i]);
}

void take(std::string_view command, char letter, std::optional<double>& into, double unit = 1) {
  if (into) return;
  if (const auto value = word_value(command, letter)) into = *value * unit;
}

// "X-5.00 Y:0.00 Z 0" in any of these ways of writing, X first; `separator` stands behind the letter.
std::optional<std::array<double, 3>> position(std::string_view text) {
  std::array<double, 3> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const char letter = kAxisLetters[i];
    const auto at = std::find_if(text.begin(), text.end(), [&](char c) {
      return std::toupper(static_cast<unsigned char>(c)) == letter;
    });
    if (at == text.end()) return {};
    std::string_view rest = text.substr(static_cast<std::size_t>(at - text.begin()) + 1);
    if (rest.starts_with(':')) rest.remove_prefix(1);
    const auto value = leading_number(rest);
    if (!value) return {};
    values[i] = *value;
  }
  return values;
}

std::optional<MachineBox> box(std::string_view low, std::string_view high) {
  const auto min = position(low), max = position(high);
  if (!min || !max) return {};
  for (std::size_t i = 0; i < min->size(); ++i)
    if (!((*min)[i] < (*max)[i])) return {};
  return MachineBox{*min, *max};
}

template <typename Values>
void scale(Values& values, double factor) {
  for (auto& value : values)
    if (value) *value *= factor;
}

}  // namespace

void SettingsReader::take(std::string_view line) {
  line = without_blanks_before(line);
  if (line.starts_with("echo:")) line = without_blanks_before(line.substr(5));
  if (line.find("Min:") != line.npos && line.find("Max:") != line.npos) return take_endstops(line);
  if (line.starts_with("area:{")) return take_area(line);
  take_command(line.substr(0, line.find(';')));
}

void SettingsReader::take_command(std::string_view command) {
  const Word word = first_word(command);
  if (word == Word{'G', 20}) inches_ = true;
  if (word == Word{'G', 21}) inches_ = false;
  if (word.letter != 'M') return;
  const bool of_other_tool = word_value(command, 'T').value_or(0) > 0;
  switch (word.number) {
    case 92:
      if (of_other_tool) return;
      return take_axes(command, limits_.steps_per_mm);
    case 203:
      if (of_other_tool) return;
      return take_axes(command, limits_.max_feed_mm_s);
    case 201:
      if (of_other_tool) return;
      return take_axes(command, limits_.max_acceleration_mm_s2);
    case 204: {
      const bool old = word_value(command, 'S').has_value();  // Marlin 1.0: S of all moves, T of retractions
      marlin::take(command, old ? 'S' : 'P', limits_.print_acceleration_mm_s2);
      marlin::take(command, old ? 'T' : 'R', limits_.retract_acceleration_mm_s2);
      marlin::take(command, old ? 'S' : 'T', limits_.travel_acceleration_mm_s2);
      return;
    }
    case 205:
      marlin::take(command, 'S', limits_.min_feed_mm_s);
      marlin::take(command, 'T', limits_.min_travel_feed_mm_s);
      marlin::take(command, 'B', limits_.min_segment_time_s, kMicrosecond);
      marlin::take(command, 'Q', limits_.min_segment_time_s, kMicrosecond);  // 1.1.0
      marlin::take(command, 'J', limits_.junction_deviation_mm);
      take_axes(command, limits_.jerk_mm_s);
      if (!limits_.jerk_mm_s[1]) limits_.jerk_mm_s[1] = limits_.jerk_mm_s[0];  // Marlin 1.0: X is X and Y
      return;
    default:
      return;
  }
}

void SettingsReader::take_endstops(std::string_view line) {
  const auto min = line.find("Min:"), max = line.find("Max:");
  if (min < max) endstops_ = box(line.substr(min + 4, max - min - 4), line.substr(max + 4));
}

// area:{full:{min:{x:0.0000,y:0.0000,z:0.0000},max:{x:220.0000,y:220.0000,z:250.0000},},}
void SettingsReader::take_area(std::string_view line) {
  const auto full = line.find("full:{");
  if (full == line.npos) return;
  const auto corner = [&](std::string_view name) -> std::string_view {
    const auto at = line.find(name, full);
    if (at == line.npos) return {};
    const auto inside = line.substr(at + name.size());
    return inside.substr(0, inside.find('}'));
  };
  area_ = box(corner("min:{"), corner("max:{"));
}

std::optional<FirmwareLimits> SettingsReader::limits() const {
  FirmwareLimits out = limits_;
  out.volume = area_ ? area_ : endstops_;
  if (inches_) {
    scale(out.steps_per_mm, 1 / kMmPerInch);
    for (PerAxis* values : {&out.max_feed_mm_s, &out.max_acceleration_mm_s2, &out.jerk_mm_s})
      scale(*values, kMmPerInch);
    for (auto* value :
         {&out.junction_deviation_mm, &out.print_acceleration_mm_s2, &out.retract_acceleration_mm_s2,
          &out.travel_acceleration_mm_s2, &out.min_feed_mm_s, &out.min_travel_feed_mm_s})
      if (*value) **value *= kMmPerInch;
    out.volume = area_;  // the endstops are told in inches and the area in mm: one of them is enough
  }
  if (out == FirmwareLimits{}) return {};
  return out;
}

}  // namespace voidpath::fw::marlin

#include "daemon/jobs/limits_json.h"

#include "daemon/json/json.h"

#include <array>
#include <optional>

namespace voidpath::daemon {
namespace {

struct NamedAxes {
  const char* name;
  fw::PerAxis fw::FirmwareLimits::*value;
};
constexpr NamedAxes kAxes[] = {{"steps_per_mm", &fw::FirmwareLimits::steps_per_mm},
                               {"max_feed_mm_s", &fw::FirmwareLimits::max_feed_mm_s},
                               {"max_acceleration_mm_s2", &fw::FirmwareLimits::max_acceleration_mm_s2},
                               {"jerk_mm_s", &fw::FirmwareLimits::jerk_mm_s}};

struct NamedNumber {
  const char* name;
  std::optional<double> fw::FirmwareLimits::*value;
};
constexpr NamedNumber kNumbers[] = {
    {"junction_deviation_mm", &fw::FirmwareLimits::junction_deviation_mm},
    {"print_acceleration_mm_s2", &fw::FirmwareLimits::print_acceleration_mm_s2},
    {"retract_acceleration_mm_s2", &fw::FirmwareLimits::retract_acceleration_mm_s2},
    {"travel_acceleration_mm_s2", &fw::FirmwareLimits::travel_acceleration_mm_s2},
    {"min_feed_mm_s", &fw::FirmwareLimits::min_feed_mm_s},
    {"min_travel_feed_mm_s", &fw::FirmwareLimits::min_travel_feed_mm_s},
    {"min_segment_time_s", &fw::FirmwareLimits::min_segment_time_s}};

Json corner_json(const std::array<double, 3>& corner) {
  Json out = Json::array();
  for (const double x : corner) out.push(x);
  return out;
}

std::optional<std::array<double, 3>> corner_from(const Json& json) {
  const auto& cells = json.items();
  if (cells.size() != 3) return std::nullopt;
  return std::array{cells[0].number(), cells[1].number(), cells[2].number()};
}

const char* name_of(fw::LineForm form) {
  switch (form) {
    case fw::LineForm::plain:
      return "plain";
    case fw::LineForm::dense:
      return "dense";
    case fw::LineForm::packed:
      return "packed";
  }
  return "";
}

}  // namespace

std::string to_text(const fw::FirmwareLimits& limits) {
  Json out = Json::object();
  for (const auto& [name, value] : kAxes) {
    Json axes = Json::array();
    for (const auto& one : limits.*value) axes.push(one ? Json(*one) : Json());
    out.set(name, std::move(axes));
  }
  for (const auto& [name, value] : kNumbers)
    if (limits.*value) out.set(name, *(limits.*value));
  if (limits.line_form != fw::LineForm::plain) out.set("lines", name_of(limits.line_form));
  if (limits.volume) {
    out.set("min_mm", corner_json(limits.volume->min_mm));
    out.set("max_mm", corner_json(limits.volume->max_mm));
  }
  return out.dump();
}

fw::FirmwareLimits limits_from(const std::string& text) {
  const Json json = Json::parse(text);
  fw::FirmwareLimits out;
  for (const auto& [name, value] : kAxes) {
    const auto& cells = json[name].items();
    for (std::size_t a = 0; a < cells.size() && a < 4; ++a)
      if (cells[a].is_number()) (out.*value)[a] = cells[a].number();
  }
  for (const auto& [name, value] : kNumbers)
    if (json[name].is_number()) out.*value = json[name].number();
  for (const auto form : {fw::LineForm::dense, fw::LineForm::packed})
    if (json["lines"].text() == name_of(form)) out.line_form = form;
  const auto low = corner_from(json["min_mm"]), high = corner_from(json["max_mm"]);
  if (low && high) out.volume = fw::MachineBox{*low, *high};
  return out;
}

}  // namespace voidpath::daemon

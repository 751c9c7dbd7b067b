#include "firmware-io/marlin/reply.h"

#include "firmware-io/heaters_off.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>

namespace voidpath::fw::marlin {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }

// Reads a number at the front of `text` and removes it.
template <typename Number>
std::optional<Number> take_number(std::string_view& text) {
  Number value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{}) return {};
  text.remove_prefix(static_cast<std::size_t>(result.ptr - text.data()));
  return value;
}

std::optional<std::uint32_t> first_integer(std::string_view text) {
  const auto at = text.find_first_of("0123456789");
  if (at == std::string_view::npos) return {};
  text.remove_prefix(at);
  return take_number<std::uint32_t>(text);
}

bool contains_any(const std::string& text, std::initializer_list<std::string_view> parts) {
  return std::any_of(parts.begin(), parts.end(),
                     [&](std::string_view part) { return text.find(part) != std::string::npos; });
}

// "T", "T0", "B", "C", "P", "L", "R": sensors of M105. Others (X, Count, @) are none.
std::string_view take_sensor_name(std::string_view text) {
  std::size_t n = 0;
  while (n < text.size() && (is_upper(text[n]) || (n > 0 && is_digit(text[n])))) ++n;
  if (n == 0 || n > 3 || n >= text.size() || text[n] != ':') return {};
  const std::string_view name = text.substr(0, n);
  const bool single = std::string_view("TBCPLR").find(name[0]) != std::string_view::npos;
  const bool numbered = std::all_of(name.begin() + 1, name.end(), is_digit);
  return single && numbered ? name : std::string_view{};
}

std::optional<Temperature> take_temperature(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  const auto actual = take_number<double>(text);
  if (!actual || !std::isfinite(*actual)) return {};
  Temperature value{*actual, 0};
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  if (!text.empty() && text.front() == '/') {
    text.remove_prefix(1);
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    if (const auto target = take_number<double>(text); target && std::isfinite(*target)) {
      value.target_c = *target;
    }
  }
  return value;
}

void name_active_tool(Sensors& sensors) {
  const auto active = sensors.find("T");
  if (active == sensors.end()) return;
  if (!sensors.count("T0")) sensors["T0"] = active->second;
  sensors.erase("T");
}

Ok parse_ok(std::string_view rest) {
  Ok ok;
  rest = trim(rest);
  if (rest.find(':') != std::string_view::npos) {
    ok.sensors = parse_temperatures(rest);
    return ok;
  }
  while (!rest.empty()) {
    const char letter = rest.front();
    if (!is_digit(letter)) rest.remove_prefix(1);
    const auto value = take_number<std::uint32_t>(rest);
    if (!value || (!rest.empty() && rest.front() != ' ')) break;  // damaged: believe no more of it
    if (letter == 'N' || is_digit(letter)) ok.line = *value;
    if (letter == 'P') ok.planner_free = static_cast<int>(*value);
    if (letter == 'B') ok.queue_free = static_cast<int>(*value);
    rest = trim(rest);
  }
  return ok;
}

Error parse_error(std::string_view text) {
  Error error;
  error.text = std::string(trim(text));
  const std::string low = lower(text);
  if (contains_any(low, {"kill() called", "system stopped", "printer halted", "printer stopped", "fatal",
                         "switched off", "maxtemp", "mintemp", "thermal runaway", "stop called",
                         "kill caused", "emergency stop", "shutdown"})) {
    error.kind = Error::Kind::fatal;
  } else if (contains_any(low, {"probing failed", "failed to enable bed leveling"})) {
    error.kind = Error::Kind::refused;
  } else if (contains_any(low, {"checksum", "line number", "linenumber", "expected line", "format error"})) {
    error.kind = Error::Kind::framing;
    if (const auto last = low.rfind("last line"); last != std::string::npos) {
      error.last_line = first_integer(std::string_view(low).substr(last));
    } else if (const auto expected = low.find("expected line"); expected != std::string::npos) {
      const auto line = first_integer(std::string_view(low).substr(expected));
      if (line && *line > 0) error.last_line = *line - 1;
    }
  }
  return error;
}

Firmware parse_firmware(std::string_view text) {
  Firmware firmware;
  std::map<std::string, std::string> values;
  std::string key;
  std::size_t at = 0;
  while (at <= text.size()) {
    const auto end = std::min(text.find(' ', at), text.size());
    const std::string_view word = text.substr(at, end - at);
    const auto colon = word.find(':');
    const bool is_key = colon != std::string_view::npos && colon > 0 && is_upper(word[0]) &&
                        std::all_of(word.begin(), word.begin() + static_cast<std::ptrdiff_t>(colon),
                                    [](char c) { return is_upper(c) || is_digit(c) || c == '_'; });
    if (is_key) {
      key = std::string(word.substr(0, colon));
      values[key] = std::string(word.substr(colon + 1));
    } else if (!key.empty() && !word.empty()) {
      values[key] += values[key].empty() ? std::string(word) : " " + std::string(word);
    }
    at = end + 1;
  }
  firmware.info.name = values["FIRMWARE_NAME"];
  firmware.info.machine = values["MACHINE_TYPE"];
  firmware.info.uuid = values["UUID"];
  std::string_view extruders = values["EXTRUDER_COUNT"];
  firmware.info.extruders = std::clamp(take_number<int>(extruders).value_or(1), 1, kMostExtruders);
  return firmware;
}

std::optional<Reply> parse_busy(std::string_view line) {
  if (line.starts_with("echo:")) line.remove_prefix(5);
  if (!line.starts_with("busy:")) return {};
  const std::string why(trim(line.substr(5)));
  return Busy{why.starts_with("paused"), why};
}

std::optional<Reply> parse_action(std::string_view line) {
  if (!line.starts_with("//")) return {};
  const std::string_view body = trim(line.substr(2));
  if (body == "Klipper state: Disconnect") return Start{};  // it restarts, and all it had read is gone
  if (!body.starts_with("action:")) return Echo{std::string(body)};  // Klipper's remarks
  const std::string_view action = body.substr(7);
  const auto blank = std::min(action.find(' '), action.size());
  return Action{std::string(action.substr(0, blank)), std::string(trim(action.substr(blank)))};
}

std::optional<Reply> parse_resend(std::string_view line) {
  const std::string low = lower(line.substr(0, 7));
  std::string_view rest;
  if (low.starts_with("resend")) {
    rest = line.substr(6);
  } else if (low.starts_with("rs ") || low.starts_with("rs:")) {
    rest = line.substr(3);
  } else {
    return {};
  }
  while (!rest.empty() && (rest.front() == ' ' || rest.front() == ':' || rest.front() == 'N')) {
    rest.remove_prefix(1);
  }
  const auto number = take_number<std::uint32_t>(rest);
  if (!number || (!rest.empty() && rest.front() != ' ')) return {};
  return Resend{*number};
}

}  // namespace

Sensors parse_temperatures(std::string_view text) {
  Sensors sensors;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (i > 0 && text[i - 1] != ' ') continue;
    const std::string_view name = take_sensor_name(text.substr(i));
    if (name.empty() || sensors.count(std::string(name))) continue;
    if (const auto value = take_temperature(text.substr(i + name.size() + 1))) {
      sensors.emplace(std::string(name), *value);
    }
  }
  name_active_tool(sensors);
  return sensors;
}

Reply parse_reply(std::string_view raw) {
  const std::string_view line = trim(raw);
  if (line == "ok" || line.starts_with("ok ")) return parse_ok(line.substr(2));
  if (line == "start") return Start{};
  if (line == "wait") return Wait{};
  if (const auto resend = parse_resend(line)) return *resend;
  if (const auto busy = parse_busy(line)) return *busy;
  if (const auto action = parse_action(line)) return *action;
  if (line.starts_with("[MP]"))
    return PackState{line.find(" ON") != line.npos, line.find(" NSP") != line.npos};
  if (line.find("RX BUF overflow") != line.npos || line.find("Full RX Buffer") != line.npos)
    return Overrun{std::string(line)};
  if (lower(line.substr(0, 6)) == "error:") return parse_error(line.substr(6));
  if (line.starts_with("!!")) {
    Error error = parse_error(line.substr(2));
    if (error.text.empty()) error = {Error::Kind::fatal, "halted", {}};
    if (error.kind == Error::Kind::other) error.kind = Error::Kind::refused;
    return error;
  }
  if (line.starts_with("fatal:")) return parse_error(line);
  if (line.find("xtruder switched off") != std::string_view::npos ||
      line.find("eated bed switched off") != std::string_view::npos) {
    return parse_error(line);  // the second half of an old Marlin's split error
  }
  if (line.starts_with("Cap:")) {
    const auto colon = line.rfind(':');
    if (colon > 4) return Capability{std::string(line.substr(4, colon - 4)), line.substr(colon + 1) == "1"};
  }
  if (line.find("FIRMWARE_NAME:") != std::string_view::npos) return parse_firmware(line);
  if (line.starts_with("echo:")) return Echo{std::string(trim(line.substr(5)))};
  if (!take_sensor_name(line).empty()) {
    Sensors sensors = parse_temperatures(line);
    if (!sensors.empty()) return TemperatureReport{std::move(sensors), line.find(" W:") != line.npos};
  }
  return Other{std::string(line)};
}

}  // namespace voidpath::fw::marlin

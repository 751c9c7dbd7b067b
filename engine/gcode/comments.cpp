#include "engine/gcode/comments.h"

#include <charconv>

namespace voidpath::gcode {
namespace {

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

bool cut_prefix(std::string_view& text, std::string_view prefix) {
  if (!text.starts_with(prefix)) return false;
  text.remove_prefix(prefix.size());
  text = trimmed(text);
  return true;
}

std::optional<double> leading_number(std::string_view text) {
  text = trimmed(text);
  double value = 0;
  const auto result =
      std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  // No printer is a kilometre tall, and "nan" parses.
  if (result.ec != std::errc() || !(value > -1e6 && value < 1e6)) return std::nullopt;
  return value;
}

/// "2, Z = 0.4" and "12, Z = 3" after Simplify3D's "layer ".
std::optional<double> height_after_equals(std::string_view text) {
  const std::size_t at = text.find("Z = ");
  if (at == std::string_view::npos) return std::nullopt;
  return leading_number(text.substr(at + 4));
}

Remark feature(std::string_view name) { return {Remark::Kind::feature, name, std::nullopt}; }

}  // namespace

Remark read_comment(std::string_view comment) {
  std::string_view text = trimmed(comment);
  if (text.empty()) return {};
  switch (text.front()) {
    case 'T':
      if (cut_prefix(text, "TYPE:")) return feature(text);
      break;
    case 'F':
      if (cut_prefix(text, "FEATURE:")) return feature(text);
      break;
    case 'f':
      if (cut_prefix(text, "feature ")) return feature(text);
      break;
    case 'P':
      if (cut_prefix(text, "PRINTING:")) return feature(text);
      break;
    case 'L':
      if (text == "LAYER_CHANGE") return {Remark::Kind::layer, {}, std::nullopt};
      if (cut_prefix(text, "LAYER:") && leading_number(text)) return {Remark::Kind::layer, {}, std::nullopt};
      break;
    case 'C':
      if (text == "CHANGE_LAYER") return {Remark::Kind::layer, {}, std::nullopt};
      break;
    case 'l':
      if (cut_prefix(text, "layer ") && leading_number(text)) {
        return {Remark::Kind::layer, {}, height_after_equals(text)};
      }
      break;
    case 'Z':
      if (cut_prefix(text, "Z:") || cut_prefix(text, "Z_HEIGHT:")) {
        if (const auto z = leading_number(text)) return {Remark::Kind::height, {}, z};
      }
      break;
    default:
      break;
  }
  return {};
}

}  // namespace voidpath::gcode

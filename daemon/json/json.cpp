#include "daemon/json/json.h"

#include <charconv>
#include <cmath>

#include <nlohmann/json.hpp>

namespace voidpath::daemon {
namespace {

using Parsed = nlohmann::ordered_json;

Json convert(const Parsed& parsed) {
  switch (parsed.type()) {
    case Parsed::value_t::boolean:
      return parsed.get<bool>();
    case Parsed::value_t::number_integer:
    case Parsed::value_t::number_unsigned:
      return parsed.get<std::int64_t>();
    case Parsed::value_t::number_float:
      return parsed.get<double>();
    case Parsed::value_t::string:
      return parsed.get<std::string>();
    case Parsed::value_t::array: {
      Json out = Json::array();
      for (const auto& item : parsed) out.push(convert(item));
      return out;
    }
    case Parsed::value_t::object: {
      Json out = Json::object();
      for (const auto& [key, value] : parsed.items()) out.set(key, convert(value));
      return out;
    }
    default:
      return {};
  }
}

/// Length of the valid UTF-8 sequence at `at`, 0 if there is none.
std::size_t sequence(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(at);
  const std::size_t length = lead < 0x80                   ? 1
                             : lead >= 0xC2 && lead < 0xE0 ? 2
                             : (lead & 0xF0) == 0xE0       ? 3
                             : lead >= 0xF0 && lead < 0xF5 ? 4
                                                           : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  }
  // Overlong forms, surrogates and what lies past U+10FFFF.
  if (length == 3 && ((lead == 0xE0 && byte(at + 1) < 0xA0) || (lead == 0xED && byte(at + 1) > 0x9F)))
    return 0;
  if (length == 4 && ((lead == 0xF0 && byte(at + 1) < 0x90) || (lead == 0xF4 && byte(at + 1) > 0x8F)))
    return 0;
  return length;
}

void write_text(std::string& out, std::string_view text) {
  static constexpr char kHex[] = "0123456789abcdef";
  out += '"';
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
      ++i;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += "\\u00";
      out += kHex[static_cast<unsigned char>(c) >> 4];
      out += kHex[static_cast<unsigned char>(c) & 15];
      ++i;
    } else if (const std::size_t length = sequence(text, i); length > 0) {
      out += text.substr(i, length);
      i += length;
    } else {
      out += "\xEF\xBF\xBD";
      ++i;
    }
  }
  out += '"';
}

void new_line(std::string& out, int indent, int depth) {
  if (indent <= 0) return;
  out += '\n';
  out.append(static_cast<std::size_t>(indent * depth), ' ');
}

}  // namespace

std::string number_text(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

Json::Json() noexcept = default;
Json::Json(std::nullptr_t) noexcept {}
Json::Json(double number) noexcept {
  if (std::isfinite(number)) value_ = number;
}
Json::Json(std::string text) : value_(std::move(text)) {}
Json::Json(const char* text) : value_(std::string(text)) {}
Json::Json(Array items) : value_(std::move(items)) {}
Json::Json(const Json& other) = default;
Json::Json(Json&& other) noexcept = default;
Json& Json::operator=(Json other) noexcept {
  value_ = std::move(other.value_);
  return *this;
}
Json::~Json() = default;

Json Json::object() {
  Json out;
  out.value_ = Object{};
  return out;
}

Json Json::array() { return Json(Array{}); }

Json Json::parse(std::string_view text) {
  try {
    return convert(Parsed::parse(text));
  } catch (const nlohmann::json::exception& error) {
    throw JsonError(error.what());
  }
}

Json& Json::set(std::string key, Json value) {
  if (!is_object()) value_ = Object{};
  auto& all = std::get<Object>(value_);
  for (auto& member : all) {
    if (member.key == key) {
      member.value = std::move(value);
      return *this;
    }
  }
  all.push_back({std::move(key), std::move(value)});
  return *this;
}

Json& Json::push(Json item) {
  if (!is_array()) value_ = Array{};
  std::get<Array>(value_).push_back(std::move(item));
  return *this;
}

const Json& Json::operator[](std::string_view key) const noexcept {
  static const Json kNull;
  for (const auto& member : members()) {
    if (member.key == key) return member.value;
  }
  return kNull;
}

const Json::Array& Json::items() const noexcept {
  static const Array kNone;
  const auto* all = std::get_if<Array>(&value_);
  return all ? *all : kNone;
}

const Json::Object& Json::members() const noexcept {
  static const Object kNone;
  const auto* all = std::get_if<Object>(&value_);
  return all ? *all : kNone;
}

double Json::number(double otherwise) const noexcept {
  if (const auto* real = std::get_if<double>(&value_)) return *real;
  if (const auto* whole = std::get_if<std::int64_t>(&value_)) return static_cast<double>(*whole);
  return otherwise;
}

std::int64_t Json::integer(std::int64_t otherwise) const noexcept {
  if (const auto* whole = std::get_if<std::int64_t>(&value_)) return *whole;
  if (const auto* real = std::get_if<double>(&value_); real && std::abs(*real) < 9e15) {
    return static_cast<std::int64_t>(*real);
  }
  return otherwise;
}

bool Json::boolean(bool otherwise) const noexcept {
  const auto* value = std::get_if<bool>(&value_);
  return value ? *value : otherwise;
}

std::string Json::text(std::string otherwise) const {
  const auto* value = std::get_if<std::string>(&value_);
  return value ? *value : otherwise;
}

std::string Json::dump(int indent) const {
  std::string out;
  write(out, indent, 0);
  return out;
}

void Json::write(std::string& out, int indent, int depth) const {
  if (is_null()) {
    out += "null";
  } else if (const auto* flag = std::get_if<bool>(&value_)) {
    out += *flag ? "true" : "false";
  } else if (const auto* whole = std::get_if<std::int64_t>(&value_)) {
    out += std::to_string(*whole);
  } else if (const auto* real = std::get_if<double>(&value_)) {
    out += number_text(*real);
  } else if (const auto* string = std::get_if<std::string>(&value_)) {
    write_text(out, *string);
  } else if (is_array()) {
    out += '[';
    for (bool first = true; const auto& item : items()) {
      if (!std::exchange(first, false)) out += ',';
      new_line(out, indent, depth + 1);
      item.write(out, indent, depth + 1);
    }
    if (!items().empty()) new_line(out, indent, depth);
    out += ']';
  } else {
    out += '{';
    for (bool first = true; const auto& member : members()) {
      if (!std::exchange(first, false)) out += ',';
      new_line(out, indent, depth + 1);
      write_text(out, member.key);
      out += indent > 0 ? ": " : ":";
      member.value.write(out, indent, depth + 1);
    }
    if (!members().empty()) new_line(out, indent, depth);
    out += '}';
  }
}

}  // namespace voidpath::daemon

#include "engine/report/markup.h"

#include "engine/orient/words.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

namespace voidpath::report {

namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

/// Length of the well-formed UTF-8 sequence at the start of text (RFC 3629); 0 if there is none.
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned lead = byte(0);
  const std::size_t n = lead < 0x80                   ? 1
                        : lead >= 0xC2 && lead < 0xE0 ? 2
                        : (lead & 0xF0) == 0xE0       ? 3
                        : lead >= 0xF0 && lead < 0xF5 ? 4
                                                      : 0;
  if (n == 0 || text.size() < n) return 0;
  for (std::size_t i = 1; i < n; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  if (lead == 0xE0 && byte(1) < 0xA0) return 0;
  if (lead == 0xED && byte(1) >= 0xA0) return 0;  // surrogates
  if (lead == 0xF0 && byte(1) < 0x90) return 0;
  if (lead == 0xF4 && byte(1) >= 0x90) return 0;
  return n;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t n = sequence_length(text);
    const char c = text.front();
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
    const bool not_a_character =
        n == 3 && (text.substr(0, 3) == "\xEF\xBF\xBE" || text.substr(0, 3) == "\xEF\xBF\xBF");
    if (n == 0 || control || not_a_character)
      out += kReplacement;
    else if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else if (c == '\'')
      out += "&#39;";
    else
      out += text.substr(0, n);
    text.remove_prefix(std::max<std::size_t>(n, 1));
  }
  return out;
}

std::string fixed(double value, int decimals) {
  std::array<char, 400> buffer;  // the longest double in fixed notation has 309 digits before the point
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
  std::string out(buffer.data(), end.ptr);
  if (out.front() == '-' && out.find_first_of("123456789") == std::string::npos) out.erase(0, 1);
  return out;
}

std::string brief(double value, int decimals) { return orient::number(value, decimals); }

std::string duration(double seconds) {
  const long s = std::lround(seconds);
  const auto two = [](long v) { return (v < 10 ? "0" : "") + std::to_string(v); };
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + two(s % 60) + " s";
  const long minutes = std::lround(seconds / 60);
  return std::to_string(minutes / 60) + " h " + two(minutes % 60) + " min";
}

std::string change(double now, double before) {
  if (!(before > 0)) return {};
  const double percent = 100 * (now - before) / before;
  const std::string digits = brief(std::abs(percent), std::abs(percent) < 10 ? 1 : 0);
  if (digits == "0") return "the same";
  return digits + " % " + (percent < 0 ? "less" : "more");
}

void attribute(std::string& out, std::string_view name, std::string_view value) {
  out += ' ';
  out += name;
  out += "=\"";
  out += value;
  out += '"';
}

void attribute(std::string& out, std::string_view name, double value) { attribute(out, name, brief(value)); }

Rgb mix(const Rgb& a, const Rgb& b, double share_of_b) {
  const double s = std::clamp(share_of_b, 0.0, 1.0);
  return {a.r + s * (b.r - a.r), a.g + s * (b.g - a.g), a.b + s * (b.b - a.b)};
}

std::string hex(const Rgb& c) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string out = "#";
  for (const double v : {c.r, c.g, c.b}) {
    const auto byte = static_cast<std::uint8_t>(std::lround(std::clamp(v, 0.0, 255.0)));
    out += digits[byte / 16];
    out += digits[byte % 16];
  }
  return out;
}

}  // namespace voidpath::report

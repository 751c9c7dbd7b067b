#include "firmware-io/s3g/words.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace voidpath::fw::s3g {
namespace {

char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }
bool is_letter(char c) { return c >= 'A' && c <= 'Z'; }

// The number at the front, taken off; 0 where there is none.
double take_number(std::string_view& text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '+')) text.remove_prefix(1);
  double value = 0;
  // An exponent is none: E is the extruder's word.
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed);
  if (end.ec == std::errc::invalid_argument) return 0;
  text.remove_prefix(static_cast<std::size_t>(end.ptr - text.data()));
  return end.ec == std::errc() && std::isfinite(value) ? value : 0;
}

}  // namespace

Words::Words(std::string_view line) {
  line = line.substr(0, line.find(';'));
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  if (line.empty() || !is_letter(capital(line.front()))) return;
  letter_ = capital(line.front());
  line.remove_prefix(1);
  // Far beyond any command's number.
  constexpr double kMostCode = 1e6;
  code_ = static_cast<int>(std::clamp(take_number(line), 0.0, kMostCode));
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  rest_ = line;
  while (!line.empty()) {
    const char word = capital(line.front());
    line.remove_prefix(1);
    if (!is_letter(word)) continue;
    seen_ |= bit(word);
    values_[index(word)] = take_number(line);
  }
}

bool Words::has_any(std::string_view words) const {
  return std::any_of(words.begin(), words.end(), [this](char word) { return has(word); });
}

}  // namespace voidpath::fw::s3g

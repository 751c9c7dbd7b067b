#include "firmware-io/marlin/file_command.h"

#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <stdexcept>

namespace voidpath::fw::marlin {
namespace {

// 0.01 µm: below any printer's step.
constexpr std::size_t kDecimals = 5;

bool is_digit(char c) { return c >= '0' && c <= '9'; }
char capital(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

void strip_own_frame(std::string& text) {
  std::size_t n = 1;
  while (n < text.size() && is_digit(text[n])) ++n;
  if (n > 1) text.erase(0, std::min(text.find_first_not_of(' ', n), text.size()));
}

void capitalise(std::string& text) {
  text[0] = capital(text[0]);
  if (text[0] != 'G') return;
  std::transform(text.begin(), text.end(), text.begin(), capital);
}

// Cuts digits behind the fifth decimal; `text` is a G line, so every number in it is a plain decimal.
std::string shorten_numbers(const std::string& text) {
  std::string out;
  std::size_t decimals = 0;
  bool fraction = false;
  for (const char c : text) {
    if (c == '.') {
      fraction = true;
      decimals = 0;
    } else if (!is_digit(c)) {
      fraction = false;
    } else if (fraction && ++decimals > kDecimals) {
      continue;
    }
    out += c;
  }
  return out;
}

}  // namespace

std::string file_command(std::string_view raw) {
  if (raw.find('\0') != std::string_view::npos) throw std::runtime_error("not G-code: binary data");
  const auto first = raw.find_first_not_of(" \t\r");
  if (first == std::string_view::npos || raw[first] == '%' || raw[first] == '@') return {};
  std::string text;
  if (capital(raw[first]) == 'N' && first + 1 < raw.size() && is_digit(raw[first + 1])) {
    text = sanitise(raw.substr(0, std::min(raw.rfind('*'), raw.size())));
    strip_own_frame(text);
  } else {
    text = sanitise(raw);
  }
  if (text.empty()) return {};
  capitalise(text);
  if (first_word(text) == Word{'M', 110}) return {};
  if (text.size() > kMaxPayload && text[0] == 'G') text = shorten_numbers(text);
  const bool shows_text = first_word(text) == Word{'M', 117} || first_word(text) == Word{'M', 118};
  if (text.size() > kMaxPayload && shows_text) {
    text.resize(kMaxPayload);
    text.erase(text.find_last_not_of(' ') + 1);
  }
  if (text.size() > kMaxPayload) {
    throw std::runtime_error("a command of " + std::to_string(text.size()) + " characters; a printer takes " +
                             std::to_string(kMaxPayload));
  }
  return text;
}

}  // namespace voidpath::fw::marlin

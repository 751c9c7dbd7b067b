#include "firmware-io/marlin/file_command.h"

#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <optional>
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

// A number as G-code writes it: sign, digits, point, digits.
struct Decimal {
  bool negative = false;
  std::string_view whole, fraction;  ///< without needless zeros
};

// Takes the number at the front of `text` away; nothing when there is none, or none so plain.
std::optional<Decimal> take_decimal(std::string_view& text) {
  Decimal number;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    number.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  const auto take_digits = [&] {
    std::size_t n = 0;
    while (n < text.size() && is_digit(text[n])) ++n;
    const std::string_view digits = text.substr(0, n);
    text.remove_prefix(n);
    return digits;
  };
  number.whole = take_digits();
  const bool digits_before = !number.whole.empty();
  if (!text.empty() && text.front() == '.') {
    text.remove_prefix(1);
    number.fraction = take_digits();
  }
  if (!digits_before && number.fraction.empty()) return {};
  number.whole.remove_prefix(std::min(number.whole.find_first_not_of('0'), number.whole.size()));
  number.fraction = number.fraction.substr(0, number.fraction.find_last_not_of('0') + 1);
  return number;
}

void append(std::string& out, const Decimal& number) {
  if (number.whole.empty() && number.fraction.empty()) {
    out += '0';
    return;
  }
  if (number.negative) out += '-';
  out += number.whole;
  if (!number.fraction.empty()) out += '.', out += number.fraction;
}

// To the nearest thousandth.
void append_rounded(std::string& out, const Decimal& number) {
  std::string digits =
      '0' + std::string(number.whole) + std::string(number.fraction.substr(0, kPlaceDecimals));
  if (number.fraction[kPlaceDecimals] >= '5') {
    std::size_t i = digits.size() - 1;
    while (digits[i] == '9') digits[i--] = '0';
    ++digits[i];
  }
  std::string_view rest = digits;
  const std::string_view fraction = rest.substr(rest.size() - kPlaceDecimals);
  rest.remove_suffix(kPlaceDecimals);
  rest.remove_prefix(std::min(rest.find_first_not_of('0'), rest.size()));
  append(out, {number.negative, rest, fraction.substr(0, fraction.find_last_not_of('0') + 1)});
}

bool is_move(const Word& word) { return word.letter == 'G' && word.number >= 0 && word.number <= 3; }
bool is_straight(const Word& word) { return word.letter == 'G' && (word.number == 0 || word.number == 1); }

}  // namespace

std::string trim_move(std::string_view line, bool absolute_mm, bool* rounded) {
  const Word word = first_word(line);
  if (!is_move(word)) return std::string(line);
  const bool rounds = absolute_mm && is_straight(word);
  bool any = false;
  std::string out;
  out.reserve(line.size());
  for (std::string_view rest = line; !rest.empty();) {
    const char letter = rest.front();
    rest.remove_prefix(1);
    if (letter == ' ') {
      if (!rest.empty() && rest.front() != ' ') out += ' ';
      continue;
    }
    const auto number = letter >= 'A' && letter <= 'Z' ? take_decimal(rest) : std::nullopt;
    if (!number || (!rest.empty() && (rest.front() == '.' || rest.front() == '-' || rest.front() == '+')))
      return std::string(line);
    out += letter;
    const bool place = letter == 'X' || letter == 'Y' || letter == 'Z';
    if (place && rounds && number->fraction.size() > kPlaceDecimals) {
      append_rounded(out, *number);
      any = true;
    } else {
      append(out, *number);
    }
  }
  if (sets_line_number(out)) return std::string(line);
  if (rounded != nullptr) *rounded = any;
  return out;
}

std::string place_of(std::string_view move, char axis) {
  const auto at = move.find(axis);
  if (at == move.npos) return {};
  std::string_view rest = move.substr(at + 1);
  const std::size_t all = rest.size();
  return take_decimal(rest) ? std::string(move.substr(at + 1, all - rest.size())) : std::string();
}

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
  if (sets_line_number(text)) return {};
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

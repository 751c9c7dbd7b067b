#include "tests/mock_printer/line_protocol.h"

#include <algorithm>
#include <charconv>

namespace voidpath::test::mock {
namespace {

/// Like strtol: blanks, sign, digits; 0 when there are none.
std::int64_t leading_integer(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  std::int64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

std::string_view command_text(std::string_view line) {
  if (const auto star = line.find('*'); star != line.npos) line = line.substr(0, star);
  if (line.size() > 1 && line[0] == 'N' && ((line[1] >= '0' && line[1] <= '9') || line[1] == '-')) {
    std::size_t at = 2;
    while (at < line.size() && line[at] >= '0' && line[at] <= '9') ++at;
    line = line.substr(at);
  }
  return trimmed(line);
}

std::uint8_t checksum_of(std::string_view text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  return static_cast<std::uint8_t>(sum);
}

void LineProtocol::reset() {
  drop_partial();
  last_number_ = 0;
  skips_left_ = 0;
}

void LineProtocol::drop_partial() {
  line_.clear();
  state_ = State::kNormal;
}

void LineProtocol::append(char byte) {
  line_ += byte;
  if (line_.size() >= kMaxCommandSize - 1) state_ = State::kRestIgnored;
}

std::optional<LineResult> LineProtocol::take(char byte) {
  const bool colon = byte == ':' && dialect_.colon_ends_line && state_ != State::kRestIgnored;
  if (byte == '\n' || byte == '\r' || colon) {
    LineResult result = finish();
    drop_partial();
    return result;
  }
  if (!dialect_.checks_lines) {
    line_ += byte;
    return std::nullopt;
  }
  switch (state_) {
    case State::kRestIgnored:
      break;
    case State::kParenthesis:
      if (byte == ')') state_ = State::kNormal;
      break;
    case State::kEscape:
      state_ = State::kNormal;
      append(byte);
      break;
    case State::kNormal:
      if (byte == '\\') {
        state_ = State::kEscape;
      } else if (byte == ';') {
        state_ = State::kRestIgnored;
      } else if (byte == '(' && parentheses_) {
        state_ = State::kParenthesis;
      } else if (byte == '\b') {
        if (!line_.empty()) line_.pop_back();
      } else {
        append(byte);
      }
      break;
  }
  return std::nullopt;
}

LineResult LineProtocol::finish() {
  if (!dialect_.checks_lines) {
    std::string text(command_text(std::string_view(line_).substr(0, line_.find(';'))));
    if (text.empty()) return IgnoredLine{true};
    const bool numbered = line_.starts_with('N');
    return AcceptedLine{
        std::move(text),
        numbered ? std::optional(leading_integer(std::string_view(line_).substr(1))) : std::nullopt};
  }
  if (line_.empty()) return IgnoredLine{true};
  // The firmware reads it as a C string.
  line_.resize(std::min(line_.find('\0'), line_.size()));
  std::string_view line = line_;
  while (!line.empty() && line.front() == ' ') line.remove_prefix(1);
  if (!line.empty() && line.front() == 'N') return check_numbered(line);
  if (dialect_.wants_number && line.find('*') != line.npos) return refuse(dialect_.no_number);
  return AcceptedLine{std::string(command_text(line)), std::nullopt};
}

LineResult LineProtocol::check_numbered(std::string_view line) {
  std::size_t number_at = 0;
  const bool renumbers = line.find("M110") != line.npos;
  // M110 may carry the number it sets behind itself.
  constexpr std::size_t kSkip = 4;
  if (renumbers && line.size() > kSkip)
    if (const auto second = line.find('N', kSkip); second != line.npos) number_at = second;
  const std::int64_t number = leading_integer(line.substr(number_at + 1));
  if (!renumbers && !dialect_.sum_first)
    if (const auto result = check_number(number)) return *result;
  const auto star = dialect_.first_star ? line.find('*') : line.rfind('*');
  if (star == line.npos) return refuse(dialect_.no_checksum);
  if (leading_integer(line.substr(star + 1)) != checksum_of(line.substr(0, star)))
    return refuse(dialect_.wrong_checksum);
  if (!renumbers && dialect_.sum_first)
    if (const auto result = check_number(number)) return *result;
  last_number_ = number;
  skips_left_ = 0;
  return AcceptedLine{std::string(command_text(line.substr(0, star))), number};
}

// What a number out of order brings about.
std::optional<LineResult> LineProtocol::check_number(std::int64_t number) {
  const auto differs = [&](std::int64_t a, std::int64_t b) {
    return dialect_.number_16_bit ? ((a ^ b) & 0xffff) != 0 : a != b;
  };
  if (!differs(number, last_number_ + 1)) return {};
  if (skips_left_ > 0) {
    --skips_left_;
    return SkippedLine{number};
  }
  if (dialect_.repeats_silent && (number == last_number_ || number == last_number_ - 1))
    return IgnoredLine{false};
  if (dialect_.names_expected)
    return RefusedLine{
        dialect_.wrong_number + std::to_string(last_number_ + 1) + " got " + std::to_string(number),
        last_number_ + 1};
  return refuse(dialect_.wrong_number);
}

RefusedLine LineProtocol::refuse(const std::string& why) const {
  return {why + std::to_string(last_number_), last_number_ + 1};
}

}  // namespace voidpath::test::mock

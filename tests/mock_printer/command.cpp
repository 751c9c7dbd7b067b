#include "tests/mock_printer/command.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace voidpath::test::mock {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

Command::Command(std::string_view text) {
  if (const auto star = text.find('*'); star != text.npos) text = text.substr(0, star);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  text_ = text;
  if (text_.empty()) return;
  const char letter = text_[0];
  if (letter != 'G' && letter != 'M' && letter != 'T') return;
  std::size_t at = 1;
  while (at < text_.size() && text_[at] == ' ') ++at;
  if (at >= text_.size() || !is_digit(text_[at])) return;
  const auto [end, error] = std::from_chars(text_.data() + at, text_.data() + text_.size(), code_);
  if (error != std::errc()) return;
  letter_ = letter;
  argument_ = static_cast<std::size_t>(end - text_.data());
  // A sub-code (G28.1) is read and ignored.
  if (argument_ < text_.size() && text_[argument_] == '.')
    for (++argument_; argument_ < text_.size() && is_digit(text_[argument_]);) ++argument_;
  while (argument_ < text_.size() && text_[argument_] == ' ') ++argument_;
}

bool Command::has(char parameter) const { return text_.find(parameter, argument_) != text_.npos; }

std::optional<double> Command::value(char parameter) const {
  auto at = text_.find(parameter, argument_);
  if (at == text_.npos) return std::nullopt;
  ++at;
  while (at < text_.size() && text_[at] == ' ') ++at;
  if (at < text_.size() && text_[at] == '+') ++at;
  double number = 0;
  const auto [end, error] =
      std::from_chars(text_.data() + at, text_.data() + text_.size(), number, std::chars_format::fixed);
  if (error != std::errc() || !std::isfinite(number)) return std::nullopt;
  // The firmware's own numbers end somewhere too; steps and integers made of this one stay in range.
  constexpr double kLargest = 2e9;
  return std::clamp(number, -kLargest, kLargest);
}

}  // namespace voidpath::test::mock

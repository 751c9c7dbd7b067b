#pragma once

#include <optional>
#include <string>
#include <string_view>

/// One G-code command as a firmware's parser sees it.
namespace voidpath::test::mock {

class Command {
 public:
  /// `text` without line number; a checksum and what follows is cut off.
  explicit Command(std::string_view text);

  const std::string& text() const { return text_; }
  /// 'G', 'M', 'T', or 0 when it is none of these.
  char letter() const { return letter_; }
  int code() const { return code_; }
  bool is(char letter, int code) const { return letter_ == letter && code_ == code; }
  bool has(char parameter) const;
  /// The parameter's number; nothing when it is absent or has none.
  std::optional<double> value(char parameter) const;
  double value_or(char parameter, double otherwise) const { return value(parameter).value_or(otherwise); }
  /// All behind the command word, for texts (M117).
  std::string_view argument() const { return std::string_view(text_).substr(argument_); }

 private:
  std::string text_;
  char letter_ = 0;
  int code_ = -1;
  std::size_t argument_ = 0;
};

}  // namespace voidpath::test::mock

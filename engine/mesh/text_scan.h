#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace voidpath::mesh {

/// A whole token as a number, whatever the locale; a leading '+' is allowed. "nan" and "inf" are numbers
/// here, for the caller to judge; a magnitude beyond double becomes infinite or nil.
bool parse_number(std::string_view token, double& value);

/// Walks text token by token. Lines end with LF, CR LF or CR alone.
class TokenScanner {
 public:
  explicit TokenScanner(std::string_view text) : text_(text) {}

  /// The next token on this or a later line; empty at the end of the text.
  std::string_view next();
  /// The next token on this line; empty at its end.
  std::string_view next_on_line();
  void skip_line();
  /// Of the token returned last, counted from 1.
  std::size_t line() const { return line_; }
  std::size_t offset() const { return at_; }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
};

/// `token` shortened and stripped of control characters, in quotes, for a message.
std::string in_quotes(std::string_view token);
/// `a` in lower case, ASCII only, equals `lower`.
bool same_word(std::string_view a, std::string_view lower);

}  // namespace voidpath::mesh

#pragma once

#include "tests/mock_printer/dialect.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>

/// From bytes to numbered, checked lines, as strict as the firmware and as blind as it: comments, escapes and
/// what is too long are cut BEFORE the checksum is verified.
namespace voidpath::test::mock {

/// A line that goes into the command queue.
struct AcceptedLine {
  std::string text;                    ///< no number, no checksum
  std::optional<std::int64_t> number;  ///< when it was numbered
};
/// A line that was refused: what to say. The receive buffer is to be flushed.
struct RefusedLine {
  std::string error;    ///< the text behind `Error:`
  std::int64_t resend;  ///< the line asked for
};
struct IgnoredLine {
  bool blank;  ///< empty or comment only; else a repeat of a line already taken
};
/// One of those that were under way when a line was asked for.
struct SkippedLine {
  std::int64_t number;
};
using LineResult = std::variant<AcceptedLine, RefusedLine, IgnoredLine, SkippedLine>;

/// Characters of a line the firmware keeps, the terminator included.
inline constexpr std::size_t kMaxCommandSize = 96;

class LineProtocol {
 public:
  explicit LineProtocol(const Dialect& dialect, bool parenthesis_comments = false)
      : dialect_(dialect), parentheses_(parenthesis_comments) {}

  /// Takes one byte; a result when it ended a line.
  std::optional<LineResult> take(char byte);
  /// Forgets a half-read line (after a flush).
  void drop_partial();
  bool has_partial() const { return !line_.empty() || state_ != State::kNormal; }
  /// The half-read line; writable, so that faults can damage it.
  std::string& partial() { return line_; }
  std::int64_t last_number() const { return last_number_; }
  /// A request went out: what follows may have been under way.
  void note_request() { skips_left_ = dialect_.skips; }
  bool awaits_resend() const { return skips_left_ > 0; }
  /// M110 executed from the queue.
  void set_last_number(std::int64_t number) { last_number_ = number; }
  void reset();

 private:
  enum class State { kNormal, kEscape, kParenthesis, kRestIgnored };
  LineResult finish();
  LineResult check_numbered(std::string_view line);
  std::optional<LineResult> check_number(std::int64_t number);
  RefusedLine refuse(const std::string& why) const;
  void append(char byte);

  Dialect dialect_;
  bool parentheses_;
  State state_ = State::kNormal;
  std::string line_;
  std::int64_t last_number_ = 0;
  int skips_left_ = 0;
};

/// A line without its leading number and without its checksum.
std::string_view command_text(std::string_view line);

/// XOR of all bytes.
std::uint8_t checksum_of(std::string_view text);

}  // namespace voidpath::test::mock

#include "engine/gcode/reader.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace voidpath::gcode {
namespace {

constexpr std::size_t kPiece = 64 * 1024;  ///< read at once, bytes
/// No firmware has codes beyond this; a larger number is not a command.
constexpr int kMaxCode = 100000;

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }
bool is_word(char c) { return c >= 'A' && c <= 'Z'; }

const char* skip_blanks(const char* p, const char* end) {
  while (p != end && is_blank(*p)) ++p;
  return p;
}

/// An unsigned whole number; leaves `p` behind it. -1: none or too large.
int whole_number(const char*& p, const char* end) {
  int value = 0;
  const auto result = std::from_chars(p, end, value);
  if (p == end || !is_digit(*p) || result.ec != std::errc() || value > kMaxCode) return -1;
  p = result.ptr;
  return value;
}

/// A decimal number without exponent; leaves `p` behind it.
bool number(const char*& p, const char* end, float& value) {
  value = 0;
  p = skip_blanks(p, end);
  if (p != end && *p == '+') ++p;
  const char* digits = p != end && *p == '-' ? p + 1 : p;
  if (digits == end || !(is_digit(*digits) || *digits == '.')) return true;  // a flag
  const auto result = std::from_chars(p, end, value, std::chars_format::fixed);
  if (result.ptr == p) {  // a lone point
    ++p;
    return true;
  }
  p = result.ptr;
  return result.ec == std::errc() && std::isfinite(value);
}

const char* skip_parenthesis(const char* p, const char* end) {
  while (p != end && *p != ')') ++p;
  return p == end ? p : p + 1;
}

}  // namespace

bool Command::has_any(std::string_view words) const {
  std::uint32_t mask = 0;
  for (const char word : words) mask |= bit(word);
  return (seen & mask) != 0;
}

Line split_line(std::string_view text) {
  Line line;
  if (const std::size_t at = text.find(';'); at != std::string_view::npos) {
    line.comment = text.substr(at + 1);
    while (!line.comment.empty() && is_blank(line.comment.back())) line.comment.remove_suffix(1);
    text = text.substr(0, at);
  }
  const char* p = skip_blanks(text.data(), text.data() + text.size());
  const char* end = text.data() + text.size();
  if (p != end && upper(*p) == 'N' && p + 1 != end && is_digit(p[1])) {
    ++p;
    while (p != end && is_digit(*p)) ++p;
    p = skip_blanks(p, end);
    // A checksum closes numbered lines only: elsewhere '*' may be part of a text.
    if (const void* star = std::memchr(p, '*', static_cast<std::size_t>(end - p)); star != nullptr) {
      end = static_cast<const char*>(star);
    }
  }
  while (end != p && is_blank(end[-1])) --end;
  line.code = std::string_view(p, static_cast<std::size_t>(end - p));
  return line;
}

Command parse_command(std::string_view code) {
  Command command;
  const char* p = code.data();
  const char* const end = p + code.size();
  while (p != end && *p == '(') p = skip_blanks(skip_parenthesis(p, end), end);
  if (p == end || !is_word(upper(*p))) return command;
  const char letter = upper(*p++);
  p = skip_blanks(p, end);
  const int number_after = whole_number(p, end);
  if (number_after < 0) return command;
  command.letter = letter;
  command.code = number_after;
  if (p != end && *p == '.') {
    ++p;
    command.subcode = std::max(0, whole_number(p, end));
  }
  while (p != end) {
    const char word = upper(*p);
    if (*p == '(') {
      p = skip_parenthesis(p, end);
      continue;
    }
    ++p;
    if (!is_word(word)) continue;
    float value = 0;
    if (!number(p, end, value)) continue;
    command.seen |= Command::bit(word);
    command.values[static_cast<std::size_t>(word - 'A')] = value;
  }
  return command;
}

LineReader::LineReader(std::istream& in) : in_(in), buffer_(kPiece + kMaxLine) {}

bool LineReader::refill() {
  if (at_end_) return false;
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  in_.read(buffer_.data() + end_, static_cast<std::streamsize>(buffer_.size() - end_));
  const auto got = static_cast<std::size_t>(in_.gcount());
  if (in_.bad()) throw std::runtime_error("reading G-code failed");
  at_end_ = got == 0;
  end_ += got;
  return got > 0;
}

bool LineReader::next(std::string_view& line) {
  std::size_t searched = begin_;
  bool overlong = false;
  for (;;) {
    const char* const from = buffer_.data() + searched;
    const void* const hit = searched < end_ ? std::memchr(from, '\n', end_ - searched) : nullptr;
    if (hit != nullptr) {
      const auto stop = static_cast<std::size_t>(static_cast<const char*>(hit) - buffer_.data());
      consumed_ += stop - begin_ + 1;
      line = std::string_view(buffer_.data() + begin_, overlong ? kMaxLine : stop - begin_);
      begin_ = stop + 1;
      break;
    }
    if (end_ - begin_ > kMaxLine) {  // keep its beginning, drop the rest as it comes
      consumed_ += end_ - begin_ - kMaxLine;
      end_ = begin_ + kMaxLine;
      overlong = true;
    }
    searched = end_ - begin_;
    if (!refill()) {
      if (begin_ == end_) return false;
      consumed_ += end_ - begin_;
      line = std::string_view(buffer_.data() + begin_, end_ - begin_);
      begin_ = end_;
      break;
    }
  }
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

}  // namespace voidpath::gcode

#pragma once

#include <array>
#include <cstdint>
#include <istream>
#include <string_view>
#include <vector>

/// Reads G-code text of any slicer. Nothing here throws on odd input: a line that says nothing is nothing.
namespace voidpath::gcode {

/// One line's words. Values are in the file's own unit.
struct Command {
  char letter = 0;  ///< 'G', 'M', 'T', ...; 0: the line holds no command
  int code = 0;
  int subcode = 0;         ///< 1 in G92.1
  std::uint32_t seen = 0;  ///< one bit a letter
  std::array<float, 26> values{};

  static constexpr std::uint32_t bit(char word) { return std::uint32_t{1} << (word - 'A'); }
  bool is(char l, int c) const { return letter == l && code == c; }
  bool has(char word) const { return (seen & bit(word)) != 0; }
  bool has_any(std::string_view words) const;
  float get(char word, float otherwise = 0) const {
    return has(word) ? values[static_cast<std::size_t>(word - 'A')] : otherwise;
  }
};

struct Line {
  std::string_view code;     ///< without line number, checksum, comment and outer blanks
  std::string_view comment;  ///< after the first ';'
};

/// Cuts a line into code and comment. "N12 G1 X1*34 ; note" has code "G1 X1".
Line split_line(std::string_view text);

/// Understands upper and lower case, words with and without blanks between, "(...)" comments. A word without
/// a number has value 0. A number may not carry an exponent: E is a word. Beyond single precision or not a
/// number: the word counts as not seen.
Command parse_command(std::string_view code);

/// Hands out a stream line by line without end-of-line characters, reading in large pieces; memory is
/// bounded whatever the input: what exceeds kMaxLine in a line is dropped. Throws std::runtime_error if the
/// stream fails.
class LineReader {
 public:
  static constexpr std::size_t kMaxLine = 64 * 1024;

  explicit LineReader(std::istream& in);
  /// The view lives until the next call.
  bool next(std::string_view& line);
  std::uint64_t bytes_read() const { return consumed_; }

 private:
  bool refill();

  std::istream& in_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t consumed_ = 0;
  bool at_end_ = false;
};

}  // namespace voidpath::gcode

#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// The bytes of Marlin's serial protocol, host to printer. Pure functions, any thread.
namespace voidpath::fw::marlin {

/// Marlin's MAX_CMD_SIZE is 96 with the terminating zero: what is longer is cut before its checksum is seen,
/// so that the line could never pass.
inline constexpr std::size_t kMaxFramed = 95;

/// What is left of kMaxFramed for the command itself: `N`, up to 9 digits, a blank, `*` and 3 digits are
/// ours. Numbers go on from print to print.
inline constexpr std::size_t kMaxPayload = kMaxFramed - 15;

/// XOR of all bytes.
std::uint8_t checksum(std::string_view bytes) noexcept;

/// `N<number> <payload>*<checksum>` and a newline. The payload must be sanitised.
std::string frame(std::uint32_t number, std::string_view payload);
/// The same behind `out`.
void append_frame(std::string& out, std::uint32_t number, std::string_view payload);
/// The same with no blank in it where the payload is a move (G0 to G3): Marlin 2 reads it alike, and four or
/// five bytes of a move are saved.
void append_dense_frame(std::string& out, std::uint32_t number, std::string_view payload);

/// The first line's command as a firmware would read it: without its comment and the blanks around it,
/// without a checksum (in texts, without the `*` alone), and without every character that a firmware drops or
/// alters before it sums the line (anything beyond printable ASCII, `\`, `*`, parentheses). Empty when
/// nothing is left. Length is not looked at.
std::string sanitise(std::string_view raw);

/// True when a firmware takes the text exactly as it stands.
bool is_clean(std::string_view payload) noexcept;

/// Cuts the byte stream from the printer into lines. Carriage returns, zero bytes and blank lines vanish.
class LineSplitter {
 public:
  void feed(std::string_view bytes) { buffer_ += bytes; }
  /// Fetches the next complete line into `line`; false when there is none yet.
  bool next(std::string& line);
  void clear() { buffer_.clear(), start_ = 0; }
  /// Behind the last line the beginning of another has come.
  bool amid_line() const noexcept { return start_ < buffer_.size(); }

 private:
  std::string buffer_;
  std::size_t start_ = 0;
};

}  // namespace voidpath::fw::marlin

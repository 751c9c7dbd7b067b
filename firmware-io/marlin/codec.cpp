#include "firmware-io/marlin/codec.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>

namespace voidpath::fw::marlin {
namespace {

// A printer's longest honest line (M115) has some 300 characters; noise without newlines must not pile up.
constexpr std::size_t kMaxReply = 4096;

constexpr std::array<bool, 256> make_allowed() {
  std::array<bool, 256> table{};
  for (unsigned char c = 0x20; c <= 0x7E; ++c)
    table[c] = c != ';' && c != '*' && c != '\\' && c != '(' && c != ')';
  return table;
}
constexpr auto kAllowed = make_allowed();

bool allowed(char c) noexcept { return kAllowed[static_cast<unsigned char>(c)]; }

// `N`, a number, perhaps a blank, the payload with or without its blanks, `*`, the sum of all that, newline.
template <bool kDense>
void append_framed(std::string& out, std::uint32_t number, std::string_view payload) {
  constexpr std::size_t kMostAround = 17;
  const std::size_t begin = out.size();
  out.resize(begin + payload.size() + kMostAround);
  char* const first = out.data() + begin;
  char* to = first;
  *to++ = 'N';
  to = std::to_chars(to, to + 10, number).ptr;
  if constexpr (kDense) {
    for (const char c : payload)
      if (c != ' ') *to++ = c;
  } else {
    *to++ = ' ';
    to = std::copy(payload.begin(), payload.end(), to);
  }
  const std::uint8_t sum = checksum({first, static_cast<std::size_t>(to - first)});
  *to++ = '*';
  to = std::to_chars(to, to + 3, sum).ptr;
  *to++ = '\n';
  out.resize(static_cast<std::size_t>(to - out.data()));
}

// G53 and its like are followed by a command of its own, which Marlin finds by the blank.
bool is_move_with_words(std::string_view payload) {
  return payload.size() > 3 && payload[0] == 'G' && payload[1] >= '0' && payload[1] <= '3' &&
         (payload[2] == ' ' || (payload[2] >= 'A' && payload[2] <= 'Z'));
}

// Where the comment begins. A semicolon cannot be quoted: Marlin cuts there in any text.
std::size_t comment_start(std::string_view raw) { return std::min(raw.find(';'), raw.size()); }

// Without balanced (comments). A lone parenthesis stays and falls to the character filter.
std::string without_parentheses(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t close = text[i] == '(' ? text.find(')', i) : std::string_view::npos;
    if (close == std::string_view::npos) {
      out += text[i];
    } else {
      i = close;
    }
  }
  return out;
}

bool carries_text(std::string_view text) {
  const auto starts = [&](std::string_view word) {
    return text.size() >= word.size() && (text[0] == 'M' || text[0] == 'm') &&
           text.substr(1, word.size() - 1) == word.substr(1);
  };
  return starts("M117") || starts("M118") || starts("M23") || starts("M0") || starts("M1 ");
}

// A checksum goes without its number too: its digits would join the command's last. In a text `*` is a
// character.
bool ends_command(char c, std::string_view command) {
  return c == '\r' || c == '\n' || (c == '*' && !carries_text(command));
}

}  // namespace

std::uint8_t checksum(std::string_view bytes) noexcept {
  std::uint8_t sum = 0;
  for (const char c : bytes) sum = static_cast<std::uint8_t>(sum ^ static_cast<unsigned char>(c));
  return sum;
}

void append_frame(std::string& out, std::uint32_t number, std::string_view payload) {
  assert(is_clean(payload));
  append_framed<false>(out, number, payload);
}

void append_dense_frame(std::string& out, std::uint32_t number, std::string_view payload) {
  if (is_move_with_words(payload))
    append_framed<true>(out, number, payload);
  else
    append_frame(out, number, payload);
}

std::string frame(std::uint32_t number, std::string_view payload) {
  std::string out;
  out.reserve(payload.size() + 16);
  append_frame(out, number, payload);
  return out;
}

std::string sanitise(std::string_view raw) {
  raw = raw.substr(0, comment_start(raw));
  const auto first = raw.find_first_not_of(" \t\r\n\v\f");
  if (first == std::string_view::npos) return {};
  raw.remove_prefix(first);
  std::string bare;
  if (raw.find('(') != raw.npos && !carries_text(raw)) raw = bare = without_parentheses(raw);
  std::string out;
  out.reserve(raw.size());
  for (const char c : raw) {
    const char shown = c == '\t' ? ' ' : c;
    if (allowed(shown)) {
      if (!(out.empty() && shown == ' ')) out += shown;
    } else if (ends_command(c, raw) && !out.empty()) {
      break;
    }
  }
  out.erase(out.find_last_not_of(' ') + 1);
  return out;
}

bool is_clean(std::string_view payload) noexcept {
  return !payload.empty() && payload.front() != ' ' && payload.back() != ' ' &&
         std::all_of(payload.begin(), payload.end(), allowed);
}

bool LineSplitter::next(std::string& line) {
  bool blank = true;
  line.clear();
  for (std::size_t i = start_; i < buffer_.size(); ++i) {
    const char c = buffer_[i];
    if (c == '\n') {
      start_ = i + 1;
      if (!blank) return true;
      line.clear();
    } else if (c != '\0' && c != '\r') {
      line += c;
      blank = blank && c == ' ';
    }
  }
  buffer_.erase(0, start_);
  start_ = 0;
  if (buffer_.size() > kMaxReply) buffer_.clear();
  return false;
}

}  // namespace voidpath::fw::marlin

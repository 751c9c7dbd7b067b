#include "firmware-io/marlin/meatpack.h"

#include <array>

namespace voidpath::fw::marlin {
namespace {

constexpr unsigned kLiteral = 15;

constexpr std::array<unsigned char, 256> make_nibbles() {
  std::array<unsigned char, 256> table{};
  table.fill(kLiteral);
  constexpr std::string_view kCommonest = "0123456789.E\nGX";
  for (std::size_t i = 0; i < kCommonest.size(); ++i)
    table[static_cast<unsigned char>(kCommonest[i])] = static_cast<unsigned char>(i);
  return table;
}
constexpr auto kNibbles = make_nibbles();

unsigned nibble(char c) { return kNibbles[static_cast<unsigned char>(c)]; }

}  // namespace

void append_packed(std::string& out, std::string_view framed) {
  for (std::size_t i = 0; i < framed.size();) {
    const char first = framed[i];
    // Behind a newline the firmware ignores the upper half.
    const bool single = first == '\n' || i + 1 == framed.size();
    const unsigned low = nibble(first), high = single ? 0 : nibble(framed[i + 1]);
    out += static_cast<char>(high << 4 | low);
    if (low == kLiteral) out += first;
    if (high == kLiteral) out += framed[i + 1];
    i += single ? 1 : 2;
  }
}

std::string pack(std::string_view framed) {
  std::string out;
  out.reserve(framed.size());
  append_packed(out, framed);
  return out;
}

}  // namespace voidpath::fw::marlin

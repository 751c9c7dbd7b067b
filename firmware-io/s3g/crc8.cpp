#include "firmware-io/s3g/crc8.h"

#include <array>

namespace voidpath::fw::s3g {
namespace {

constexpr unsigned kReflectedPolynomial = 0x8C;

constexpr std::array<std::uint8_t, 256> make_table() {
  std::array<std::uint8_t, 256> table{};
  for (unsigned i = 0; i < table.size(); ++i) {
    unsigned rest = i;
    for (int bit = 0; bit < 8; ++bit)
      rest = (rest & 1U) != 0 ? (rest >> 1) ^ kReflectedPolynomial : rest >> 1;
    table[i] = static_cast<std::uint8_t>(rest);
  }
  return table;
}
constexpr auto kTable = make_table();

}  // namespace

std::uint8_t crc8(std::string_view bytes) noexcept {
  std::uint8_t crc = 0;
  for (const char c : bytes) crc = kTable[crc ^ static_cast<std::uint8_t>(c)];
  return crc;
}

}  // namespace voidpath::fw::s3g

#include "engine/toolpath/emit/gcode_text.h"

#include <charconv>
#include <cmath>

namespace voidpath::toolpath {

void put_scaled(std::string& out, std::int64_t value, int decimals) {
  std::uint64_t left = value < 0 ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  while (decimals > 0 && left % 10 == 0) {
    left /= 10;
    --decimals;
  }
  if (value < 0) out += '-';
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, left).ptr;
  const auto count = static_cast<int>(end - digits);
  if (decimals == 0) {
    out.append(digits, end);
    return;
  }
  if (count > decimals) {
    out.append(digits, end - decimals);
    out += '.';
    out.append(end - decimals, end);
    return;
  }
  out += "0.";
  out.append(static_cast<std::size_t>(decimals - count), '0');
  out.append(digits, end);
}

std::string decimal(double value, int decimals) {
  std::string out;
  put_scaled(out, std::llround(value * std::pow(10.0, decimals)), decimals);
  return out;
}

}  // namespace voidpath::toolpath

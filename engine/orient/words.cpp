#include "engine/orient/words.h"

#include <array>
#include <charconv>

namespace voidpath::orient {

std::string number(double value, int decimals) {
  std::array<char, 400> buffer;  // the longest double in fixed notation has 309 digits before the point
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
  std::string out(buffer.data(), end.ptr);
  if (out.find('.') != std::string::npos) {
    while (out.back() == '0') out.pop_back();
    if (out.back() == '.') out.pop_back();
  }
  return out == "-0" ? "0" : out;
}

}  // namespace voidpath::orient

#pragma once

#include <string>

namespace voidpath::orient {

/// "12.3": fixed, trailing zeros and a bare point dropped; the same in every locale.
std::string number(double value, int decimals);

}  // namespace voidpath::orient

#pragma once

#include <cstdint>
#include <string>

namespace voidpath::toolpath {

/// A whole number of 10^-decimals as a decimal without trailing zeros: (1500, 3) is "1.5".
void put_scaled(std::string& out, std::int64_t value, int decimals);

/// Rounded to so many decimals, without trailing zeros.
std::string decimal(double value, int decimals);

}  // namespace voidpath::toolpath

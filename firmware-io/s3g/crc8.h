#pragma once

#include <cstdint>
#include <string_view>

namespace voidpath::fw::s3g {

/// CRC-8 as of Maxim's 1-Wire parts: polynomial x⁸+x⁵+x⁴+1, low bit first, starting at 0, nothing added at
/// the end. "123456789" gives 0xA1.
std::uint8_t crc8(std::string_view bytes) noexcept;

}  // namespace voidpath::fw::s3g

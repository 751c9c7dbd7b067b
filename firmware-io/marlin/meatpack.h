#pragma once

#include <cstddef>
#include <string>
#include <string_view>

/// MeatPack: two characters of G-code in a byte where both are among the fifteen commonest. Here always in
/// its mode without blanks, in which `E` takes the blank's place. Pure.
///
/// The firmware unpacks behind its receive buffer, so packed bytes are what fills that buffer. Its unpacker
/// does not know of lines: bytes lost or flushed can leave it in the middle of a pair, and nothing but its
/// reset helps.
namespace voidpath::fw::marlin {

/// Packing off, pending halves forgotten, then a newline that ends whatever stands in the line buffer.
inline constexpr std::string_view kPackingOff = "\xFF\xFF\xF9\n";
/// Packing on, without blanks. Each command is answered by `[MP] PV01 ON|OFF NSP|ESP`.
inline constexpr std::string_view kPackingOn = "\xFF\xFF\xFB\xFF\xFF\xF7";

/// A framed line, newline included, packed. It ends on a byte's border.
std::string pack(std::string_view framed);
/// The same behind `out`.
void append_packed(std::string& out, std::string_view framed);

}  // namespace voidpath::fw::marlin

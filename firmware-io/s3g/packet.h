#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

/// Framing of S3G: 0xD5, length, payload, CRC-8 of the payload. Pure.
namespace voidpath::fw::s3g {

inline constexpr char kStartByte = '\xD5';
inline constexpr std::size_t kMaxPayload = 32;
/// Start, length, CRC.
inline constexpr std::size_t kFrameBytes = 3;

/// Not for payloads beyond kMaxPayload.
std::string frame(std::string_view payload);

struct Packet {
  std::string payload;  ///< empty when damaged
  bool good = false;    ///< the CRC fits
};

/// Cuts a stream of bytes into packets. What stands between packets is skipped, and so is a start byte in the
/// place of the length: no packet is that long, it begins one. Holds at most one packet.
class PacketReader {
 public:
  /// The packet that this byte completes.
  std::optional<Packet> take(char byte);
  /// Forgets a packet that has begun.
  void clear() noexcept { state_ = State::start; }
  bool in_packet() const noexcept { return state_ != State::start; }

 private:
  enum class State { start, length, payload, crc };
  State state_ = State::start;
  std::size_t wanted_ = 0;
  std::string payload_;
};

}  // namespace voidpath::fw::s3g

#include "firmware-io/s3g/packet.h"

#include "firmware-io/s3g/crc8.h"

#include <cassert>

namespace voidpath::fw::s3g {

std::string frame(std::string_view payload) {
  assert(payload.size() <= kMaxPayload);
  std::string out;
  out.reserve(payload.size() + kFrameBytes);
  out += kStartByte;
  out += static_cast<char>(payload.size());
  out += payload;
  out += static_cast<char>(crc8(payload));
  return out;
}

std::optional<Packet> PacketReader::take(char byte) {
  switch (state_) {
    case State::start:
      if (byte == kStartByte) state_ = State::length;
      return {};
    case State::length:
      if (byte == kStartByte) return {};
      wanted_ = static_cast<unsigned char>(byte);
      payload_.clear();
      state_ = wanted_ > 0 && wanted_ <= kMaxPayload ? State::payload : State::start;
      return {};
    case State::payload:
      payload_ += byte;
      if (payload_.size() == wanted_) state_ = State::crc;
      return {};
    case State::crc:
      break;
  }
  state_ = State::start;
  if (static_cast<std::uint8_t>(byte) != crc8(payload_)) return Packet{};
  return Packet{payload_, true};
}

}  // namespace voidpath::fw::s3g

#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

/// The numbers of the S3G/X3G protocol as spoken by MakerBot's and Sailfish firmware, and payloads made of
/// them.
namespace voidpath::fw::s3g {

/// Answered at once, whatever the queue holds.
enum class Query : std::uint8_t {
  version = 0,
  free_buffer = 2,
  abort = 7,
  pause = 8,  ///< a toggle
  tool = 10,
  finished = 11,
  position = 21,
  stop = 22,
  board_status = 23,
  build = 24,
  advanced_version = 27
};

/// Second byte behind Query::tool and the tool's number.
enum class ToolQuery : std::uint8_t {
  temperature = 2,
  ready = 22,
  bed_temperature = 30,
  target = 32,
  bed_target = 33,
  bed_ready = 35
};

/// Queued.
enum class Command : std::uint8_t {
  home_min = 131,
  home_max = 132,
  delay = 133,
  change_tool = 134,
  wait_tool = 135,
  tool = 136,
  enable_axes = 137,
  move_steps = 139,  ///< absolute, unaccelerated
  set_position = 140,
  wait_bed = 141,
  store_home = 143,
  recall_home = 144,
  pot = 145,
  beep = 147,
  message = 149,
  percent = 150,
  song = 151,
  build_start = 153,
  build_end = 154,
  move = 155,  ///< accelerated, relative by axis
  acceleration = 156,
  pause_at_z = 158
};

/// Second byte behind Command::tool and the tool's number.
enum class ToolCommand : std::uint8_t { set_temperature = 3, fan = 12, extra = 13, set_bed = 31 };

/// First byte of a reply. Old firmware leaves out the highest bit.
enum class ReplyCode : std::uint8_t {
  generic_error = 0x00,
  ok = 0x01,
  overflow = 0x02,
  bad_crc = 0x03,
  too_long = 0x04,
  unsupported = 0x05,
  more = 0x06,
  downstream_timeout = 0x07,
  tool_lock = 0x08,
  cancelled = 0x09,
  busy = 0x0A,
  heater_failure = 0x0B,
  packet_timeout = 0x0C
};
inline ReplyCode reply_code(char byte) noexcept {
  return static_cast<ReplyCode>(static_cast<unsigned char>(byte) & 0x7FU);
}

/// Bytes of the queue when it is empty.
inline constexpr std::uint32_t kQueueBytes = 512;

/// Stepper axes; bit n of a mask is axis n.
inline constexpr std::size_t kAxes = 5;
inline constexpr std::size_t kX = 0, kY = 1, kZ = 2, kA = 3, kB = 4;
inline constexpr char kAxisLetters[] = "XYZAB";
inline constexpr std::uint8_t bit_of(std::size_t axis) noexcept {
  return static_cast<std::uint8_t>(1U << axis);
}

/// States in the reply to Query::build.
enum class BuildState : std::uint8_t {
  none = 0,
  running = 1,
  done = 2,
  paused = 3,
  cancelled = 4,
  cancelling = 5
};

/// Bits in the reply to Query::board_status.
inline constexpr std::uint8_t kHeatShutdown = 0x40;
inline constexpr std::uint8_t kCancelling = 0x20;
inline constexpr std::uint8_t kPowerError = 0x80;

/// Puts a payload together, little-endian.
class Payload {
 public:
  explicit Payload(Command command) { u8(static_cast<std::uint8_t>(command)); }
  explicit Payload(Query query) { u8(static_cast<std::uint8_t>(query)); }

  Payload& u8(std::uint8_t v) { return little(v, 1); }
  Payload& u16(std::uint16_t v) { return little(v, 2); }
  Payload& u32(std::uint32_t v) { return little(v, 4); }
  Payload& i16(std::int16_t v) { return u16(static_cast<std::uint16_t>(v)); }
  Payload& i32(std::int32_t v) { return u32(static_cast<std::uint32_t>(v)); }
  Payload& f32(float v) { return u32(std::bit_cast<std::uint32_t>(v)); }
  Payload& text(std::string_view v) {
    bytes_ += v;
    bytes_ += '\0';
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  Payload& little(std::uint32_t v, int count) {
    for (int i = 0; i < count; ++i) bytes_ += static_cast<char>((v >> (8 * i)) & 0xFFU);
    return *this;
  }
  std::string bytes_;
};

/// `count` bytes at `at`, little-endian; bytes beyond the end are zero.
inline std::uint32_t little_endian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t out = 0;
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i) {
    out |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  }
  return out;
}

}  // namespace voidpath::fw::s3g

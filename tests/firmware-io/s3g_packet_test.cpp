#include "firmware-io/s3g/crc8.h"
#include "firmware-io/s3g/link.h"
#include "firmware-io/s3g/packet.h"
#include "firmware-io/s3g/protocol.h"

#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath::fw::s3g;

namespace {

std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int v : values) out += static_cast<char>(v);
  return out;
}

std::vector<Packet> read_all(PacketReader& reader, const std::string& stream) {
  std::vector<Packet> out;
  for (const char c : stream) {
    if (const auto packet = reader.take(c)) out.push_back(*packet);
  }
  return out;
}

std::string tool(int number, ToolCommand command, std::int16_t value) {
  return Payload(Command::tool)
      .u8(static_cast<std::uint8_t>(number))
      .u8(static_cast<std::uint8_t>(command))
      .u8(2)
      .i16(value)
      .bytes();
}

}  // namespace

TEST_CASE("the CRC has the published check value", "[s3g]") { CHECK(crc8("123456789") == 0xA1); }

TEST_CASE("frames are those of the protocol's description", "[s3g]") {
  CHECK(hex(frame(Payload(Query::free_buffer).bytes())) == "D5 01 02 BC");
  CHECK(hex(frame(Payload(Query::version).u16(100).bytes())) == "D5 03 00 64 00 61");
  CHECK(hex(frame(Payload(Query::pause).bytes())) == "D5 01 08 C2");
  CHECK(hex(frame(Payload(Query::abort).bytes())) == "D5 01 07 83");
  CHECK(hex(frame(Payload(Query::finished).bytes())) == "D5 01 0B 20");
  CHECK(hex(frame(Payload(Query::tool).u8(0).u8(2).bytes())) == "D5 03 0A 00 02 D6");
  CHECK(hex(frame(tool(0, ToolCommand::set_temperature, 205))) == "D5 06 88 00 03 02 CD 00 B1");
  CHECK(hex(frame(Payload(Command::delay).u32(1000).bytes())) == "D5 05 85 E8 03 00 00 A8");
  CHECK(hex(frame(bytes({0x81}))) == "D5 01 81 D2");
  CHECK(hex(frame(bytes({0x82}))) == "D5 01 82 30");
}

TEST_CASE("what is framed is read back, whatever stands around it", "[s3g]") {
  PacketReader reader;
  for (std::size_t length = 1; length <= kMaxPayload; ++length) {
    const std::string payload(length, static_cast<char>(length * 37));
    const auto packets = read_all(reader, "noise" + frame(payload) + bytes({0, 1, 2}));
    REQUIRE(packets.size() == 1);
    CHECK(packets[0].good);
    CHECK(packets[0].payload == payload);
    CHECK_FALSE(reader.in_packet());
  }
}

TEST_CASE("a doubled start byte, an impossible length and a damaged byte harm one packet at most", "[s3g]") {
  PacketReader reader;
  const std::string ok = frame(bytes({0x81}));
  CHECK(read_all(reader, bytes({0xD5, 0xD5}) + ok).size() == 1);
  CHECK(read_all(reader, bytes({0xD5, 0}) + ok).size() == 1);
  CHECK(read_all(reader, bytes({0xD5, 33}) + ok).size() == 1);
  for (std::size_t at = 2; at < 4; ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = ok;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      const auto packets = read_all(reader, damaged + ok);
      REQUIRE(packets.size() == 2);
      CHECK_FALSE(packets[0].good);
      CHECK(packets[1].good);
    }
  }
}

TEST_CASE("replies of old firmware lack the highest bit", "[s3g]") {
  CHECK(reply_code('\x01') == ReplyCode::ok);
  CHECK(reply_code('\x81') == ReplyCode::ok);
  CHECK(reply_code('\x89') == ReplyCode::cancelled);
}

TEST_CASE("numbers come out of replies as they went in", "[s3g]") {
  const std::string payload = Payload(Command::delay).u32(0x89ABCDEF).bytes();
  CHECK(little_endian(payload, 1, 4) == 0x89ABCDEF);
  CHECK(little_endian(payload, 3, 2) == 0x89AB);
  CHECK(little_endian(payload, 4, 4) == 0x89);  // what is not there is zero
}

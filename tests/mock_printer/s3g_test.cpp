#include "tests/mock_printer/mock_s3g.h"

#include <initializer_list>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath::test::mock;

namespace {

std::string bytes(std::initializer_list<int> values) {
  std::string out;
  for (const int v : values) out += static_cast<char>(v);
  return out;
}

std::string say(MockS3g& printer, std::initializer_list<int> values, double seconds = 0) {
  printer.feed(bytes(values));
  printer.advance_to(printer.now() + seconds);
  return printer.take_output();
}

/// With its CRC, from the protocol's own polynomial, bit by bit.
std::string packet(const std::string& payload) {
  unsigned crc = 0;
  for (const char c : payload) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = (crc & 1U) != 0 ? crc >> 1 ^ 0x8CU : crc >> 1;
  }
  return bytes({0xD5, static_cast<int>(payload.size())}) + payload + bytes({static_cast<int>(crc)});
}

const std::string kOk = bytes({0xD5, 1, 0x81, 0xD2});
const std::string kFull = bytes({0xD5, 1, 0x82, 0x30});

}  // namespace

TEST_CASE("the queue holds 512 bytes, counted by payload, and says when it is full", "[s3g]") {
  MockS3g printer;
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}) == packet(bytes({0x81, 0, 2, 0, 0})));
  // The first delay of ten seconds runs; those after it fill the queue.
  const std::string delay = packet(bytes({133, 0x10, 0x27, 0, 0}));
  int taken = 0;
  for (;; ++taken) {
    printer.feed(delay);
    const std::string answer = printer.take_output();
    if (answer == kFull) break;
    REQUIRE(answer == kOk);
    REQUIRE(taken < 200);
  }
  CHECK(taken == 1 + 512 / 5);
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}) == packet(bytes({0x81, 512 % 5, 0, 0, 0})));
  printer.advance_to(10.5);
  printer.feed(delay);
  CHECK(printer.take_output() == kOk);
}

TEST_CASE("a damaged packet is told, one that does not go on is given up after 0.2 s", "[s3g]") {
  MockS3g printer;
  CHECK(say(printer, {0xD5, 1, 2, 0xBD}) == packet(bytes({0x83})));
  CHECK(say(printer, {0xD5, 40}) == packet(bytes({0x84})));
  CHECK(say(printer, {0xD5, 5, 1, 2}, 0.19).empty());
  printer.advance_to(printer.now() + 0.02);
  CHECK(printer.take_output() == packet(bytes({0x8C})));
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}).size() == 8);
}

TEST_CASE("noise between packets costs what comes while its refusal is sent", "[s3g]") {
  const std::string abort = packet(bytes({7}));
  const auto hears_behind = [&](std::size_t zeros, double silence) {
    S3gOptions wired;
    wired.baud = 115200;
    MockS3g printer(wired);
    printer.feed(std::string(zeros, '\0'));
    if (silence > 0) printer.advance_to(printer.now() + silence);
    printer.feed(abort);
    printer.advance_to(printer.now() + 1);
    return printer.aborts() == 1;
  };
  CHECK(hears_behind(0, 0));
  CHECK_FALSE(hears_behind(35, 0));
  CHECK(hears_behind(35, 0.02));
  MockS3g printer;
  CHECK(say(printer, {0}) == packet(bytes({0x80})));
  CHECK(say(printer, {0xD5, 0xD5}) == packet(bytes({0x84})));
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}).size() == 8);
}

TEST_CASE("what must never be sent is kept as a violation", "[s3g]") {
  const auto violations = [](const std::string& payload) {
    MockS3g printer;
    printer.feed(packet(payload));
    printer.advance_to(100);
    return printer.violations().size();
  };
  CHECK(violations(bytes({132, 3, 100, 0, 0, 0, 20, 0})) == 0);
  CHECK(violations(bytes({132, 4, 100, 0, 0, 0, 20, 0})) == 1);  // Z to the far end
  CHECK(violations(bytes({131, 1, 100, 0, 0, 0, 20, 0})) == 1);
  CHECK(violations(bytes({134, 1})) == 1);
  CHECK(violations(bytes({133, 1, 2})) == 1);
  CHECK(violations(bytes({136, 0, 3})) == 1);
  CHECK(violations(bytes({141, 0, 0, 0, 0, 0})) == 1);  // no heated bed
  CHECK(violations(bytes({200})) == 1);
  CHECK(violations(bytes({150, 101, 0})) == 1);
  CHECK(violations(bytes({136, 0, 3, 2, 205, 0})) == 0);
  CHECK(violations(bytes({136, 0, 3, 3, 205, 0})) == 1);
}

TEST_CASE("a heating wait holds the queue, a dead heater shuts it", "[s3g]") {
  MockS3g printer;
  printer.feed(packet(bytes({136, 0, 3, 2, 100, 0})));
  printer.feed(packet(bytes({135, 0, 100, 0, 100, 0})));
  printer.feed(packet(bytes({150, 5, 0})));
  CHECK(printer.progress() == 2);
  printer.advance_to(120);
  CHECK(printer.progress() == 3);
  CHECK(printer.hotend().temperature() > 97);
  printer.shut_heaters_down();
  printer.take_output();
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}) == packet(bytes({0x89})));
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}) == packet(bytes({0x8B})));
  CHECK(say(printer, {0xD5, 1, 7, 0x83}) == packet(bytes({0x8B})));
  printer.feed(packet(bytes({150, 6, 0})));
  CHECK(printer.take_output() == packet(bytes({0x8B})));
  CHECK(printer.aborts() == 0);
}

TEST_CASE("a cancel at the panel is told once, instead of the next reply", "[s3g]") {
  MockS3g printer;
  printer.cancel_at_panel();
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}) == packet(bytes({0x89})));
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}).size() == 8);
}

TEST_CASE("a cancelled build stands still at once, is over when the head has left, and stays cancelled",
          "[s3g]") {
  MockS3g printer;
  const std::string build = bytes({153, 0, 0, 0, 0, 'a', 0}), stats = packet(bytes({24}));
  const auto state = [&] {
    printer.feed(stats);
    return static_cast<int>(printer.take_output().at(3));
  };
  printer.feed(packet(build));
  CHECK(printer.take_output() == kOk);
  REQUIRE(state() == 1);
  printer.cancel_at_panel();
  CHECK(state() == 5);
  printer.feed(packet(bytes({150, 6, 0})));
  CHECK(printer.take_output() == kOk);
  CHECK(printer.queued_bytes() == 3);
  printer.advance_to(printer.now() + 5);
  CHECK(printer.queued_bytes() == 0);
  CHECK(say(printer, {0xD5, 1, 2, 0xBC}) == packet(bytes({0x89})));
  CHECK(state() == 4);
  printer.feed(packet(build));
  printer.take_output();
  REQUIRE(state() == 1);
  printer.feed(packet(bytes({7})));
  CHECK(printer.take_output() == kOk);
  CHECK(state() == 5);
}

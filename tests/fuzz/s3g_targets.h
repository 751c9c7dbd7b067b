#pragma once

#include "firmware-io/s3g/driver.h"
#include "firmware-io/s3g/encoder.h"
#include "firmware-io/s3g/packet.h"
#include "tests/firmware-io/driver_bench.h"

#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// What the S3G fuzz targets run: also called with seeded random input by the tests.
namespace voidpath::test {

/// Any bytes give packets of legal length; what was framed among them is found behind a full packet of zeros.
inline void fuzz_s3g_packet(const std::uint8_t* data, std::size_t size) {
  fw::s3g::PacketReader reader;
  for (std::size_t i = 0; i < size; ++i) {
    if (const auto packet = reader.take(static_cast<char>(data[i]))) {
      assert(packet->payload.size() <= fw::s3g::kMaxPayload);
      assert(packet->good != packet->payload.empty());
    }
  }
  for (std::size_t i = 0; i < fw::s3g::kMaxPayload + fw::s3g::kFrameBytes; ++i) reader.take('\0');
  std::size_t found = 0;
  for (const char c : fw::s3g::frame("\x81")) {
    if (const auto packet = reader.take(c)) found += packet->good && packet->payload == "\x81" ? 1U : 0U;
  }
  assert(found == 1);
  (void)found;
}

/// Any text gives actions that fit a packet, or a refusal that leaves everything as it was.
inline void fuzz_s3g_encoder(const std::uint8_t* data, std::size_t size) {
  fw::s3g::Machine machine;
  machine.extruders = size > 0 && data[0] % 2 == 1 ? 2 : 1;
  machine.heated_bed = machine.extruders == 2;
  fw::s3g::Encoder encoder(machine);
  std::string_view text(reinterpret_cast<const char*>(data), size);
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const fw::s3g::Stand before = encoder.stand();
    try {
      for (const auto& action : encoder.encode(line).actions) {
        assert(!action.payload.empty() && action.payload.size() <= fw::s3g::kMaxPayload);
        assert(static_cast<unsigned char>(action.payload[0]) >= 128);
      }
    } catch (const fw::s3g::EncodeError&) {
      assert(encoder.stand() == before);
    }
  }
}

/// A driver that prints, against a peer that answers as the input says: well, damaged, with anything, or not
/// at all, while the user presses every button.
class HostileS3g {
 public:
  HostileS3g(const std::uint8_t* data, std::size_t size)
      : data_(data), size_(size), driver_({}, clock_, recorder_, [this](const fw::Event&) { ++events_; }) {}

  void run() {
    driver_.opened(t_);
    while (at_ < size_) {
      step();
      // What is written is little: one packet at a time, and the stop that goes around it.
      assert(driver_.output().size() < 4096);
      driver_.output().clear();
      assert(!std::isnan(driver_.deadline()));
      if (driver_.closing()) driver_.opened(t_);
    }
    driver_.shut_down(t_);
    driver_.lost("the end");
    assert(driver_.closing() && driver_.finished());
  }

 private:
  std::uint8_t take() { return at_ < size_ ? data_[at_++] : std::uint8_t{0}; }
  std::string bytes(std::size_t count) {
    std::string out;
    for (std::size_t i = 0; i < count; ++i) out += static_cast<char>(take());
    return out;
  }
  void pass(double seconds) {
    t_ += seconds;
    clock_.now = t_;
    if (t_ >= driver_.deadline()) driver_.elapsed(t_);
  }

  void step() {
    const std::uint8_t what = take();
    switch (what % 16) {
      case 0:
        return driver_.received(bytes(1U + take() % 40U), t_);
      case 1:
        driver_.print(std::make_unique<MemorySource>(file()), t_);
        return;
      case 2:
        return driver_.pause();
      case 3:
        return driver_.resume(t_);
      case 4:
        return driver_.cancel("user", t_);
      case 5:
        if (take() % 8 == 0) driver_.halt("button", t_);
        return;
      case 6:
        return driver_.command("G1 X" + std::to_string(take()), t_);
      case 7:
        return pass(0.5);
      case 8:
        return pass(12);
      case 9:
      case 10:
        return driver_.received(fw::s3g::frame(bytes(1U + take() % 31U)), t_);
      case 11:
        return driver_.received(fw::s3g::frame(std::string(1, static_cast<char>(0x80 | (what >> 4)))), t_);
      default:
        // A good answer, as long as the questions' answers are.
        driver_.received(fw::s3g::frame(good(what >> 4)), t_);
        return pass(0.01);
    }
  }

  std::string good(unsigned which) {
    static constexpr std::size_t kLengths[] = {1, 2, 3, 5, 12, 23, 10, 1};
    std::string out(kLengths[which % 8], '\0');
    out[0] = '\x81';
    for (std::size_t i = 1; i < out.size(); ++i) out[i] = static_cast<char>(take() % 4);
    return out;
  }
  std::vector<std::string> file() {
    return {"M104 S200", "M109 S200", "G28",  "G92 X0 Y0 Z0", "M83", "G1 X10 E1",
            "M0",        "G1 X20 E1", "M400", "G4 P5",        "M84"};
  }

  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
  double t_ = 0;
  std::size_t events_ = 0;
  FakeClock clock_;
  fw::FlightRecorder recorder_;
  fw::s3g::Driver driver_;
};

inline void fuzz_s3g_driver(const std::uint8_t* data, std::size_t size) { HostileS3g(data, size).run(); }

}  // namespace voidpath::test

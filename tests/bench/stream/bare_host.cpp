#include "tests/bench/stream/bare_host.h"

#include "firmware-io/line_source.h"
#include "firmware-io/marlin/codec.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/transport/serial_port.h"
#include "tests/bench/stream/wire_printer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string_view>
#include <vector>

#include <poll.h>

namespace voidpath::bench {
namespace {

// The printer has booted and said all it had to say.
constexpr double kBoot_s = 0.1;
// A rest ends so much before the wire runs dry: awakenings are late by up to this.
constexpr double kLead_s = 0.0004;
constexpr double kBitsPerByte = 10;

/// All that is to be sent, and where each line of it ends.
struct Frames {
  std::string bytes;
  std::vector<std::size_t> ends;
};

Frames frames_of(const std::string& file) {
  Frames frames;
  const auto source = fw::open_gcode_file(file);
  std::uint32_t number = 0;
  fw::marlin::append_frame(frames.bytes, number, "M110 N0");
  frames.ends.push_back(frames.bytes.size());
  while (const auto line = source->next()) {
    fw::marlin::append_dense_frame(frames.bytes, ++number, line->text);
    frames.ends.push_back(frames.bytes.size());
  }
  return frames;
}

void sleep_s(double seconds, int fd) {
  const timespec time{0, static_cast<long>(std::clamp(seconds, 0.0, 0.9) * 1e9)};
  pollfd waited{fd, POLLIN, 0};
  ::ppoll(&waited, fd < 0 ? 0 : 1, &time, nullptr);
}

}  // namespace

int stream_bare(const std::string& port, int baud, const std::string& file, int window, bool rest) {
  const Frames frames = frames_of(file);
  const auto transport = fw::open_serial_port(port, baud, true);
  const double byte_s = kBitsPerByte / baud;
  std::array<char, 4096> buffer;
  sleep_s(kBoot_s, -1);
  while (transport->read(buffer) > 0) {
  }
  const CpuUse before = cpu_use();
  std::size_t written = 0, acknowledged = 0;
  double wire_free_s = 0;
  bool at_line_start = true;
  while (acknowledged < frames.ends.size()) {
    const std::size_t begin = acknowledged == 0 ? 0 : frames.ends[acknowledged - 1];
    // The greeting goes alone: it sets the numbers.
    const std::size_t most =
        acknowledged == 0 ? frames.ends.front() : begin + static_cast<std::size_t>(window);
    const std::size_t end = std::min(most, frames.bytes.size());
    if (end > written) {
      const double now = monotonic_s();
      const std::size_t n = transport->write(std::string_view(frames.bytes).substr(written, end - written));
      written += n;
      wire_free_s = std::max(wire_free_s, now) + static_cast<double>(n) * byte_s;
    }
    std::size_t n = 0;
    if (rest && acknowledged > 0) sleep_s(wire_free_s - kLead_s - monotonic_s(), -1);
    if (rest) n = transport->read(buffer);
    if (n == 0) {
      sleep_s(0.5, transport->fd());
      n = transport->read(buffer);
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (at_line_start && buffer[i] == 'o') ++acknowledged;
      at_line_start = buffer[i] == '\n';
    }
  }
  const CpuUse use = cpu_use() - before;
  std::printf("%.6f %.6f %.0f\n", use.user_s, use.kernel_s, use.sleeps);
  return 0;
}

}  // namespace voidpath::bench

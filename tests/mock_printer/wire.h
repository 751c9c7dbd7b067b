#pragma once

#include <deque>
#include <limits>
#include <string>
#include <string_view>

/// One direction of the serial link: bytes arrive in order, each after its own time on the wire and the
/// latency of the way. Without baud and latency they are there at once.
namespace voidpath::test::mock {

class Wire {
 public:
  /// `baud` 0: no limit. `latency` one way, s.
  Wire(double baud, double latency) : byte_seconds_(baud > 0 ? kBitsPerByte / baud : 0), latency_(latency) {}

  /// Bytes handed to the sending end at `now`.
  void send(double now, std::string_view bytes) {
    if (free_at_ < now) free_at_ = now;
    if (byte_seconds_ == 0 && !runs_.empty() && runs_.back().first == now + latency_) {
      runs_.back().bytes += bytes;
      return;
    }
    if (bytes.empty()) return;
    runs_.push_back({free_at_ + byte_seconds_ + latency_, std::string(bytes), 0});
    free_at_ += byte_seconds_ * static_cast<double>(bytes.size());
  }
  bool empty() const { return runs_.empty(); }
  /// When the next byte arrives, infinity when none is under way.
  double next() const {
    if (runs_.empty()) return std::numeric_limits<double>::infinity();
    return runs_.front().first + byte_seconds_ * static_cast<double>(runs_.front().done);
  }
  /// When what was sent first is there completely; infinity when nothing is under way.
  double next_complete() const {
    if (runs_.empty()) return std::numeric_limits<double>::infinity();
    return runs_.front().first + byte_seconds_ * static_cast<double>(runs_.front().bytes.size() - 1);
  }
  /// The next byte; not when empty.
  char pop() {
    Run& run = runs_.front();
    const char byte = run.bytes[run.done++];
    if (run.done == run.bytes.size()) runs_.pop_front();
    return byte;
  }
  void clear() { runs_.clear(); }

 private:
  static constexpr double kBitsPerByte = 10;  ///< 8N1
  struct Run {
    double first;  ///< arrival of its first byte, s
    std::string bytes;
    std::size_t done;
  };
  std::deque<Run> runs_;
  double byte_seconds_, latency_;
  double free_at_ = 0;
};

}  // namespace voidpath::test::mock

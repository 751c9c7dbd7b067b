#pragma once

#include <filesystem>
#include <memory>

namespace voidpath::fw {

/// Seconds that only ever grow; where they start is nobody's business. Any thread.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now_s() const noexcept = 0;
};

/// Another clock as it stood when it was last looked at: what belongs together gets one time, and a clock is
/// read once for it. One thread.
class HeldClock final : public Clock {
 public:
  explicit HeldClock(const Clock& of) : of_(of), held_s_(of.now_s()) {}
  void look() noexcept { held_s_ = of_.now_s(); }
  double now_s() const noexcept override { return held_s_; }

 private:
  const Clock& of_;
  double held_s_;
};

/// CLOCK_MONOTONIC.
std::shared_ptr<const Clock> steady_clock();

/// The clock a mock printer publishes. The file is mapped shared and holds, little-endian: 8 bytes magic
/// "VPCLOCK1", then an 8-byte double, the seconds, written atomically by the mock.
/// Throws std::runtime_error naming the file if it cannot be mapped or lacks the magic.
std::shared_ptr<const Clock> mapped_clock(const std::filesystem::path& file);

}  // namespace voidpath::fw

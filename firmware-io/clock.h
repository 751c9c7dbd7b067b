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

/// CLOCK_MONOTONIC.
std::shared_ptr<const Clock> steady_clock();

/// The clock a mock printer publishes. The file is mapped shared and holds, little-endian: 8 bytes magic
/// "VPCLOCK1", then an 8-byte double, the seconds, written atomically by the mock.
/// Throws std::runtime_error naming the file if it cannot be mapped or lacks the magic.
std::shared_ptr<const Clock> mapped_clock(const std::filesystem::path& file);

}  // namespace voidpath::fw

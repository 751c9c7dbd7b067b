#pragma once

#include "firmware-io/s3g/protocol.h"

#include <array>
#include <cstdint>
#include <string>

namespace voidpath::fw::s3g {

/// Where the motors stand, in the firmware's steps, as far as the host knows.
struct Stand {
  std::array<std::int32_t, kAxes> steps{};
  std::uint8_t known = bit_of(kA) | bit_of(kB);  ///< X, Y, Z only once the file has said so
  bool operator==(const Stand&) const = default;
};

/// One queued command. Sent twice, all do the same as sent once, but for a move of filament and a delay.
struct Action {
  enum class Kind { move, delay, home, wait_tool, wait_bed, other };
  std::string payload;
  Kind kind = Kind::other;
  int tool = 0;  ///< of wait_tool
  Stand before, after;
  bool repeatable() const noexcept {
    if (kind == Kind::delay) return false;
    return before.steps[kA] == after.steps[kA] && before.steps[kB] == after.steps[kB];
  }
};

}  // namespace voidpath::fw::s3g

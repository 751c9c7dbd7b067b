#include "daemon/pins/led.h"

#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace voidpath::daemon {
namespace {

// Seconds lit, dark, lit, dark...
constexpr std::array<double, 2> kIdle{0.1, 2.9};
constexpr std::array<double, 2> kWaiting{0.5, 0.5};
constexpr std::array<double, 4> kPaused{0.1, 0.2, 0.1, 1.6};
constexpr std::array<double, 2> kFault{0.1, 0.1};

std::span<const double> pattern_of(LedState state) noexcept {
  switch (state) {
    case LedState::idle:
      return kIdle;
    case LedState::waiting_bed:
      return kWaiting;
    case LedState::paused:
      return kPaused;
    case LedState::fault:
      return kFault;
    case LedState::off:
    case LedState::working:
      break;
  }
  return {};
}

}  // namespace

Lit led_at(LedState state, double phase_s) noexcept {
  const auto pattern = pattern_of(state);
  if (pattern.empty()) return {state == LedState::working, std::numeric_limits<double>::infinity()};
  double period = 0;
  for (const double part : pattern) period += part;
  double left = std::fmod(phase_s, period);
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    if (left < pattern[i]) return {i % 2 == 0, pattern[i] - left};
    left -= pattern[i];
  }
  return {true, pattern[0]};  // the period's end, by rounding
}

std::string_view name_of(LedState state) noexcept {
  constexpr std::array<std::string_view, 6> kNames{"off",    "idle", "working", "waiting for a clear bed",
                                                   "paused", "fault"};
  return kNames[static_cast<std::size_t>(state)];
}

}  // namespace voidpath::daemon

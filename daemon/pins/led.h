#pragma once

#include <string_view>

/// What one lamp can tell from across the room.
namespace voidpath::daemon {

enum class LedState {
  off,
  idle,         ///< a blink every three seconds: it lives
  working,      ///< steady
  waiting_bed,  ///< slow, even blinking: take the part off
  paused,       ///< double blinks
  fault,        ///< fast blinking
};

struct Lit {
  bool lit = false;
  double for_s = 0;  ///< until that changes; infinity: it does not
};
/// `phase_s`: since the state began.
Lit led_at(LedState state, double phase_s) noexcept;

std::string_view name_of(LedState state) noexcept;

}  // namespace voidpath::daemon

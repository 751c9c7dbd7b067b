#include "firmware-io/gpio/relay.h"

namespace voidpath::fw {

bool Relay::drive_off() noexcept {
  try {
    pin_->set(false);
    return true;
  } catch (const PinError&) {
    return false;
  }
}

bool Relay::cut() noexcept {
  cuts_.fetch_add(1);  // before the pin: on() looks at it after
  const bool done = drive_off();
  wanted_.store(false);
  return done;
}

bool Relay::off() noexcept {
  wanted_.store(false);
  return drive_off();
}

bool Relay::on() {
  if (is_cut()) return false;
  pin_->set(true);
  // A cut that came between the look and the switch has found the pin still off: off again.
  if (is_cut()) {
    drive_off();
    return false;
  }
  wanted_.store(true);
  return true;
}

}  // namespace voidpath::fw

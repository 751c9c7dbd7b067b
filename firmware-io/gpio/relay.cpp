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
  return drive_off();
}

bool Relay::off() noexcept {
  on_.store(0);
  return drive_off();
}

bool Relay::on() {
  const std::uint32_t before = cuts_.load();
  if (before != forgiven_.load()) return false;
  pin_->set(true);
  // A cut that came between the look and the switch has found the pin still off: off again.
  if (cuts_.load() != before) {
    drive_off();
    return false;
  }
  on_.store(std::uint64_t{before} + 1);
  return true;
}

}  // namespace voidpath::fw

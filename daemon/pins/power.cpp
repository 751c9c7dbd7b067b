#include "daemon/pins/power.h"

#include <utility>

namespace voidpath::daemon {

Power::Power(Executor& loop, std::unique_ptr<fw::OutputPin> pin, double power_up_s, double idle_off_s,
             std::function<void()> changed)
    : loop_(loop),
      relay_(std::move(pin)),
      power_up_s_(power_up_s),
      idle_off_s_(idle_off_s),
      changed_(std::move(changed)) {}

Power::~Power() {
  loop_.cancel(up_timer_);
  loop_.cancel(idle_timer_);
}

bool Power::switch_on() {
  if (relay_.is_on()) return true;
  if (!relay_.on()) return false;
  trouble_.clear();
  on_since_s_ = loop_.now_s();
  idle_since_s_.reset();
  loop_.cancel(up_timer_);
  up_timer_ = loop_.after(power_up_s_, [this] { changed_(); });
  return true;
}

void Power::switch_off() noexcept {
  loop_.cancel(up_timer_);
  loop_.cancel(idle_timer_);
  idle_since_s_.reset();
  relay_.off();
}

void Power::begin_idle() {
  if (idle_since_s_ || idle_off_s_ <= 0 || !relay_.is_on()) return;
  idle_since_s_ = loop_.now_s();
  idle_timer_ = loop_.after(idle_off_s_, [this] {
    switch_off();
    changed_();
  });
}

void Power::update(bool work) {
  if (!work) return begin_idle();
  loop_.cancel(idle_timer_);
  idle_since_s_.reset();
  try {
    switch_on();
  } catch (const fw::PinError& error) {
    trouble_ = error.what();
  }
}

bool Power::ready() const noexcept { return relay_.is_on() && loop_.now_s() >= on_since_s_ + power_up_s_; }

const char* Power::words() const noexcept {
  if (relay_.is_cut()) return "cut off";
  return relay_.is_on() ? "on" : "off";
}

}  // namespace voidpath::daemon

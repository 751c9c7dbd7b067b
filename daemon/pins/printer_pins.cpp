#include "daemon/pins/printer_pins.h"

#include <cmath>

namespace voidpath::daemon {
namespace {

fw::PinOptions options_of(const config::PinConfig& pin) {
  fw::PinOptions out;
  out.chip = pin.chip;
  out.line = pin.line;
  out.active_low = pin.active_low;
  switch (pin.bias) {
    case config::PinBias::as_is:
      out.bias = fw::Bias::as_is;
      break;
    case config::PinBias::disabled:
      out.bias = fw::Bias::disabled;
      break;
    case config::PinBias::pull_up:
      out.bias = fw::Bias::pull_up;
      break;
    case config::PinBias::pull_down:
      out.bias = fw::Bias::pull_down;
      break;
  }
  return out;
}

/// Runs `make`, and says whose pin it was where that fails.
template <class Make>
auto named(const std::string& printer, const char* name, Make make) {
  try {
    return make();
  } catch (const fw::PinError& error) {
    throw fw::PinError("printer " + printer + ", pins." + name + ": " + error.what());
  }
}

std::string use_of(const char* name) { return std::string("voidpath ") + name; }

}  // namespace

PrinterPins::PrinterPins(Executor& loop, const config::PinsConfig& config, fw::Pins& pins,
                         const std::string& printer, PinHooks hooks)
    : loop_(loop),
      pins_(pins),
      printer_(printer),
      hooks_(std::move(hooks)),
      light_printing_(config.light_printing) {
  // The relay before all else: whatever fails after this, it is off.
  if (auto relay = output(config.relay, "relay")) {
    power_ = std::make_unique<Power>(loop_, std::move(relay), config.power_up_s, config.idle_off_s,
                                     [this] { hooks_.changed(); });
  }
  led_ = output(config.led, "led");
  light_ = output(config.light, "light");
  button_ = contact(config.bed_button, "bed_button", [this] {
    if (!button_->failure().empty()) {
      hooks_.note("the bed button's pin failed: " + button_->failure());
    } else if (button_->active()) {
      hooks_.bed_pressed();
    }
    hooks_.changed();
  });
  door_ = contact(config.door, "door",
                  [this] { guard_changed(*door_, "the door was opened", "the door was closed"); });
  filament_ = contact(config.filament, "filament", [this] {
    guard_changed(*filament_, "the filament ran out", "there is filament again");
  });
  if (config.emergency_stop) start_stop(*config.emergency_stop);
}

PrinterPins::~PrinterPins() {
  *alive_ = false;
  stop_.reset();
  loop_.cancel(led_timer_);
  drive(led_, false, "led");
  drive(light_, false, "light");
}

std::unique_ptr<fw::OutputPin> PrinterPins::output(const std::optional<config::PinConfig>& pin,
                                                   const char* name) {
  if (!pin) return nullptr;
  return named(printer_, name, [&] { return pins_.output(options_of(*pin), use_of(name), false); });
}

std::unique_ptr<Contact> PrinterPins::contact(const std::optional<config::PinConfig>& pin, const char* name,
                                              Task changed) {
  if (!pin) return nullptr;
  return named(printer_, name, [&] {
    return std::make_unique<Contact>(loop_, pins_.input(options_of(*pin), use_of(name)),
                                     pin->debounce_ms / 1000, std::move(changed));
  });
}

void PrinterPins::start_stop(const config::PinConfig& pin) {
  fw::EmergencyStopOptions options;
  options.debounce_s = pin.debounce_ms / 1000;
  fw::EmergencyStopActions actions;
  actions.cut = [this] { cut(); };
  actions.halt = hooks_.halt;
  actions.report = [this, alive = alive_, &loop = loop_](bool stopped, const std::string& reason) {
    loop.post([this, alive, stopped, reason] {
      if (*alive) stop_reported(stopped, reason);
    });
  };
  stop_ = named(printer_, "emergency_stop", [&] {
    return std::make_unique<fw::EmergencyStop>(pins_.input(options_of(pin), use_of("emergency_stop")),
                                               options, std::move(actions));
  });
}

void PrinterPins::cut() noexcept {
  if (power_) power_->cut();
}

void PrinterPins::stop_reported(bool stopped, const std::string& reason) {
  hooks_.note(reason);
  if (stopped) hooks_.stopped(reason);
  show_led();
  hooks_.changed();
}

void PrinterPins::guard_changed(const Contact& guard, const char* active, const char* inactive) {
  const bool bad = guard.active() || !guard.failure().empty();
  const std::string what = guard.failure().empty() ? bad ? active : inactive : guard.failure();
  hooks_.note(what);
  if (bad) hooks_.pause(what);
  show_led();
  hooks_.changed();
}

void PrinterPins::update(const Activity& now) {
  const bool begins_or_ends = now.printing != activity_.printing;
  activity_ = now;
  if (power_) power_->update(wants_power());
  if (light_printing_ && begins_or_ends) drive(light_, light_on_ = now.printing, "light");
  show_led();
}

// A print that has failed may long count as running: while the store is full.
bool PrinterPins::wants_power() const noexcept {
  return (activity_.printing || activity_.about_to_print) && fault_.empty();
}

void PrinterPins::fault(const std::string& reason) {
  fault_ = reason;
  if (power_) power_->switch_off();
  show_led();
}

void PrinterPins::disconnected(const std::string& reason) {
  const bool was = std::exchange(activity_.connected, false);
  if (activity_.printing) return fault(reason);
  // A board may well start anew as its supply comes on.
  if (was && power_ && power_->ready()) power_->switch_off();
}

void PrinterPins::acknowledge() {
  if (power_) {
    const auto seen = power_->relay().cuts();  // before the look at the switch: a later cut must stand
    if (stop_pulled()) return;
    power_->relay().forgive(seen);
    power_->forget_trouble();
  }
  fault_.clear();
  show_led();
}

std::string PrinterPins::blocker() const {
  if (stop_pulled()) return "the emergency stop is pulled";
  if (door_ && !door_->failure().empty()) return "the door's pin failed: " + door_->failure();
  if (door_ && door_->active()) return "the door is open";
  if (filament_ && !filament_->failure().empty())
    return "the filament sensor's pin failed: " + filament_->failure();
  if (filament_ && filament_->active()) return "there is no filament";
  if (power_ && !power_->trouble().empty()) return "the power cannot be switched on: " + power_->trouble();
  return {};
}

bool PrinterPins::power_by_hand(bool on) {
  if (!on) {
    power_->switch_off();
    return true;
  }
  const bool done = power_->switch_on();
  power_->update(wants_power());  // the idle time begins
  return done;
}

void PrinterPins::light_by_hand(bool on) {
  light_->set(on);
  light_on_ = on;
}

LedState PrinterPins::led_state() const {
  const bool pin_failed =
      (door_ && !door_->failure().empty()) || (filament_ && !filament_->failure().empty());
  if (stop_pulled() || activity_.held || !fault_.empty() || pin_failed ||
      (power_ && !power_->trouble().empty()))
    return LedState::fault;
  if (activity_.paused) return LedState::paused;
  if (activity_.printing) return LedState::working;
  return activity_.bed_clear ? LedState::idle : LedState::waiting_bed;
}

void PrinterPins::show_led() {
  if (!led_) return;
  const double now = loop_.now_s();
  if (const LedState state = led_state(); state != shown_) {
    shown_ = state;
    shown_since_s_ = now;
  }
  loop_.cancel(led_timer_);
  const Lit lit = led_at(shown_, now - shown_since_s_);
  drive(led_, lit.lit, "led");
  if (led_ && std::isfinite(lit.for_s)) led_timer_ = loop_.after(lit.for_s, [this] { show_led(); });
}

// A lamp that fails is given up: nobody's print ends for it.
void PrinterPins::drive(std::unique_ptr<fw::OutputPin>& lamp, bool lit, const char* name) noexcept {
  if (!lamp) return;
  try {
    lamp->set(lit);
  } catch (const fw::PinError& error) {
    lamp.reset();
    if (*alive_) hooks_.note(std::string("the ") + name + " is given up: " + error.what());
  }
}

std::vector<std::pair<std::string, std::string>> PrinterPins::words() const {
  std::vector<std::pair<std::string, std::string>> out;
  const auto add = [&](const char* name, const Contact* contact, const char* active, const char* inactive) {
    if (contact == nullptr) return;
    out.emplace_back(name, !contact->failure().empty() ? "failed: " + contact->failure()
                           : contact->active()         ? active
                                                       : inactive);
  };
  if (stop_) out.emplace_back("emergency stop", stop_->pulled() ? "pulled" : "free");
  add("door", door_.get(), "open", "closed");
  add("filament", filament_.get(), "none left", "there");
  add("bed button", button_.get(), "pressed", "not pressed");
  if (power_) out.emplace_back("power", power_->words());
  if (light_) out.emplace_back("light", light_on_ ? "on" : "off");
  if (led_) out.emplace_back("lamp", name_of(shown_));
  return out;
}

void switch_pins_off(const config::DaemonConfig& config, fw::Pins& pins) {
  std::optional<fw::PinError> first;
  for (const auto& printer : config.printers) {
    const auto& p = printer.pins;
    for (const auto& [name, pin] : {std::pair("relay", &p.relay), {"led", &p.led}, {"light", &p.light}}) {
      if (!*pin) continue;
      try {
        named(printer.name, name, [&] { return pins.output(options_of(**pin), use_of(name), false); });
      } catch (const fw::PinError& error) {
        if (!first) first = error;
      }
    }
  }
  if (first) throw *first;
}

}  // namespace voidpath::daemon

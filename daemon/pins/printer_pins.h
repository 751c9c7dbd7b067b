#pragma once

#include "config/config.h"
#include "daemon/executor.h"
#include "daemon/pins/contact.h"
#include "daemon/pins/led.h"
#include "daemon/pins/power.h"
#include "firmware-io/gpio/emergency_stop.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::daemon {

/// What pins want of the rest. Loop thread, but for halt.
struct PinHooks {
  /// On the emergency stop's own thread, after the power is cut. Must wait on no lock.
  std::function<void()> halt;
  std::function<void(const std::string& reason)> stopped;
  std::function<void()> bed_pressed;
  std::function<void(const std::string& reason)> pause;
  /// For the log.
  std::function<void(const std::string& what)> note;
  /// Something users see, or blocker() or power_ready(), is another than before.
  std::function<void()> changed;
};

/// What a printer is at, as far as its pins care.
struct Activity {
  bool connected = false;
  bool printing = false;  ///< heating and pauses included
  bool paused = false;
  bool about_to_print = false;  ///< all there but the power
  bool bed_clear = false;
  bool held = false;
};

/// All that is wired to the computer for one printer. Loop thread, but for cut().
class PrinterPins {
 public:
  /// Throws fw::PinError naming printer, pin and what is wrong.
  PrinterPins(Executor& loop, const config::PinsConfig& config, fw::Pins& pins, const std::string& printer,
              PinHooks hooks);
  /// Power off, lamps out.
  ~PrinterPins();
  PrinterPins(const PrinterPins&) = delete;
  PrinterPins& operator=(const PrinterPins&) = delete;

  /// Power off until acknowledge(). Any thread, at once, past all locks.
  void cut() noexcept;

  void update(const Activity& now);
  /// A print has failed: power off until acknowledge(), but by hand.
  void fault(const std::string& reason);
  /// The connection is lost.
  void disconnected(const std::string& reason);
  /// The user has seen to what was wrong. Nothing while the emergency stop is pulled.
  void acknowledge();

  bool stop_pulled() const noexcept { return stop_ && stop_->pulled(); }
  /// Why nothing may begin or go on, in plain words; empty: it may.
  std::string blocker() const;
  /// A print may begin as far as its supply goes.
  bool power_ready() const noexcept { return !power_ || power_->ready(); }

  bool has_power() const noexcept { return power_ != nullptr; }
  bool has_light() const noexcept { return light_ != nullptr; }
  /// False while a cut stands. Throws fw::PinError.
  bool power_by_hand(bool on);
  /// Until the next print begins or ends. Throws fw::PinError.
  void light_by_hand(bool on);

  /// Name and state of each pin there is, for people.
  std::vector<std::pair<std::string, std::string>> words() const;

 private:
  using Task = std::function<void()>;
  std::unique_ptr<Contact> contact(const std::optional<config::PinConfig>& pin, const char* name,
                                   std::function<void()> changed);
  std::unique_ptr<fw::OutputPin> output(const std::optional<config::PinConfig>& pin, const char* name);
  void start_stop(const config::PinConfig& pin);
  void stop_reported(bool stopped, const std::string& reason);
  void guard_changed(const Contact& guard, const char* active, const char* inactive);
  bool wants_power() const noexcept;
  void show_led();
  void drive(std::unique_ptr<fw::OutputPin>& lamp, bool lit, const char* name) noexcept;
  LedState led_state() const;

  Executor& loop_;
  fw::Pins& pins_;
  std::string printer_;
  PinHooks hooks_;
  bool light_printing_;
  Activity activity_;
  std::string fault_;
  std::unique_ptr<fw::OutputPin> led_;
  std::unique_ptr<fw::OutputPin> light_;
  bool light_on_ = false;
  LedState shown_ = LedState::off;
  double shown_since_s_ = 0;
  Executor::TimerId led_timer_ = 0;
  std::unique_ptr<Contact> button_;
  std::unique_ptr<Contact> door_;
  std::unique_ptr<Contact> filament_;
  std::unique_ptr<Power> power_;
  std::shared_ptr<bool> alive_ = std::make_shared<bool>(true);
  std::unique_ptr<fw::EmergencyStop> stop_;  ///< last: its thread ends before all it uses
};

/// Drives every output of the configuration to its off state, for when no daemon does. Throws fw::PinError
/// for the first that could not be, after trying all.
void switch_pins_off(const config::DaemonConfig& config, fw::Pins& pins);

}  // namespace voidpath::daemon

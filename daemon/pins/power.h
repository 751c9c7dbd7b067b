#pragma once

#include "daemon/executor.h"
#include "firmware-io/gpio/relay.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace voidpath::daemon {

/// When a printer's supply is on: from the moment a print is to begin, or by hand, until it has been idle for
/// long enough, or something is wrong. Loop thread, but for cut().
class Power {
 public:
  /// `changed` is called when ready() or words() change by themselves.
  Power(Executor& loop, std::unique_ptr<fw::OutputPin> pin, double power_up_s, double idle_off_s,
        std::function<void()> changed);
  ~Power();
  Power(const Power&) = delete;
  Power& operator=(const Power&) = delete;

  /// Any thread, at once, past all locks. Stands until it is forgiven.
  bool cut() noexcept { return relay_.cut(); }
  fw::Relay& relay() noexcept { return relay_; }

  /// A print runs or is to begin: on. Else: off after the idle time.
  void update(bool work);
  /// On for long enough that a print may begin.
  bool ready() const noexcept;
  /// False while a cut stands. Throws PinError.
  bool switch_on();
  void switch_off() noexcept;
  /// Why it could not be switched on; empty: it could.
  const std::string& trouble() const noexcept { return trouble_; }
  /// It is tried again when it is next wanted.
  void forget_trouble() noexcept { trouble_.clear(); }
  const char* words() const noexcept;

 private:
  void begin_idle();

  Executor& loop_;
  fw::Relay relay_;
  const double power_up_s_;
  const double idle_off_s_;
  std::function<void()> changed_;
  double on_since_s_ = 0;
  std::optional<double> idle_since_s_;
  Executor::TimerId up_timer_ = 0;
  Executor::TimerId idle_timer_ = 0;
  std::string trouble_;
};

}  // namespace voidpath::daemon

#pragma once

#include "daemon/executor.h"
#include "firmware-io/gpio/debounce.h"
#include "firmware-io/gpio/pins.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace voidpath::daemon {

/// A debounced input on the loop's thread.
class Contact {
 public:
  /// `changed` is called with each settled change, and once when the pin fails. Throws PinError.
  Contact(Executor& loop, std::unique_ptr<fw::InputPin> pin, double quiet_s, std::function<void()> changed);
  ~Contact();
  Contact(const Contact&) = delete;
  Contact& operator=(const Contact&) = delete;

  bool active() const noexcept { return contact_.settled(); }
  /// Why the pin can no longer be read; it is then left alone. Empty: it can.
  const std::string& failure() const noexcept { return failure_; }

 private:
  void read();
  void settle(double now_s);

  Executor& loop_;
  std::unique_ptr<fw::InputPin> pin_;
  fw::Debounce contact_;
  std::function<void()> changed_;
  std::string failure_;
  Executor::TimerId timer_ = 0;
};

}  // namespace voidpath::daemon

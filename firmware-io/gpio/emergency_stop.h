#pragma once

#include "firmware-io/gpio/pins.h"

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

namespace voidpath::fw {

struct EmergencyStopOptions {
  /// For how long the switch must be active before it counts. 0: the edge alone is enough, however short.
  double debounce_s = 0;
  /// The level is looked at so often besides, s, in case an edge was lost.
  double look_s = 0.25;
};

/// What is done, in this order, on the switch's own thread. None may throw. `cut` and `halt` must not wait
/// for any lock; `report` comes when all is done and may.
struct EmergencyStopActions {
  std::function<void()> cut;   ///< the power
  std::function<void()> halt;  ///< the session
  /// stopped: the switch was pulled, or the pin failed, which counts as pulled; else it was let go.
  std::function<void(bool stopped, const std::string& reason)> report;
};

/// The thread of an emergency-stop switch. It waits for an edge on the pin and does nothing else; a pin that
/// is active at the start, or fails, stops as well. Commands nobody waits for, and is commanded by nobody.
class EmergencyStop {
 public:
  /// Throws PinError and std::system_error.
  EmergencyStop(std::unique_ptr<InputPin> pin, EmergencyStopOptions options, EmergencyStopActions actions);
  ~EmergencyStop();
  EmergencyStop(const EmergencyStop&) = delete;
  EmergencyStop& operator=(const EmergencyStop&) = delete;

  /// Pulled, as far as the thread has seen; before the power is cut for it. Any thread.
  bool pulled() const noexcept { return pulled_.load(); }

 private:
  void run() noexcept;
  void stop(const std::string& reason);
  void tell(std::optional<bool> active);

  std::unique_ptr<InputPin> pin_;
  const EmergencyStopOptions options_;
  const EmergencyStopActions actions_;
  std::atomic<bool> pulled_{false};
  int end_fd_ = -1;
  std::thread thread_;
};

}  // namespace voidpath::fw

#pragma once

#include <cstdint>
#include <functional>

namespace voidpath::daemon {

/// The one thread that owns jobs, store and state, seen from those who work on it.
class Executor {
 public:
  using Task = std::function<void()>;
  using TimerId = std::uint64_t;
  virtual ~Executor() = default;

  /// Any thread. Runs the task on the loop, in order of posting. Tasks must not throw.
  virtual void post(Task task) = 0;
  /// Loop thread. Runs once, `seconds` from now.
  virtual TimerId after(double seconds, Task task) = 0;
  /// Loop thread. Unknown or spent ids are ignored.
  virtual void cancel(TimerId timer) noexcept = 0;
  /// Loop thread. Calls `task` whenever fd is readable, until remove_fd. The fd stays the caller's.
  virtual void add_fd(int fd, Task task) = 0;
  virtual void remove_fd(int fd) noexcept = 0;
  /// Any thread. CLOCK_MONOTONIC in s, or a test's clock.
  virtual double now_s() const noexcept = 0;
};

}  // namespace voidpath::daemon

#pragma once

#include "daemon/executor.h"

#include <functional>
#include <map>
#include <mutex>
#include <vector>

namespace voidpath::daemon {

/// epoll, timers, and tasks from other threads. All members belong to the thread that calls run(), but for
/// post(), quit() and now_s(), which any thread may call.
class EventLoop final : public Executor {
 public:
  EventLoop();  ///< throws std::system_error
  ~EventLoop() override;
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  void post(Task task) override;
  TimerId after(double seconds, Task task) override;
  void cancel(TimerId timer) noexcept override;
  double now_s() const noexcept override;

  void add_fd(int fd, Task task) override;
  void remove_fd(int fd) noexcept override;

  /// Runs until quit().
  void run();
  void quit() noexcept;

 private:
  int wait_ms() const;
  void run_due();
  void run_posted();

  struct Timer {
    double due_s;
    Task task;
  };
  int epoll_ = -1;
  int wake_ = -1;
  std::map<int, Task> readers_;
  std::map<TimerId, Timer> timers_;
  TimerId last_timer_ = 0;
  std::mutex mutex_;  ///< guards posted_ and quit_
  std::vector<Task> posted_;
  bool quit_ = false;
};

/// Blocks SIGTERM and SIGINT for this thread and those it starts later, so that take_signals can read them.
/// Call before any thread exists.
void block_signals();

/// A descriptor that becomes readable at SIGTERM or SIGINT. Throws std::system_error.
int open_signal_fd();
/// The next pending signal, 0 if there is none.
int read_signal(int fd) noexcept;

}  // namespace voidpath::daemon

#pragma once

#include <exception>
#include <functional>
#include <stop_token>
#include <string_view>

namespace voidpath::run {

/// Thrown by Context::check() when the caller asked the work to stop, or its time is over.
class Stopped : public std::exception {
 public:
  const char* what() const noexcept override { return "stopped on request"; }
};

/// Handed to every long call: how to stop it, how it tells how far it is, how many threads it may use.
/// Copyable and cheap. check() and progress() may be called from any thread; the progress callback is
/// called from whichever thread reports and must be thread-safe and quick.
struct Context {
  std::stop_token stop;
  /// Phase ("orient", "slice", ...) and its fraction done in [0, 1].
  std::function<void(std::string_view phase, double fraction)> on_progress;
  /// Upper bound on worker threads; 0 means one per processor. Results never depend on it.
  unsigned threads = 0;
  /// Asked by every check(): whether the time allowed for this work is over. Must be thread-safe and quick.
  /// Whoever sets it catches the Stopped that follows.
  std::function<bool()> over;

  void check() const {
    if (stop.stop_requested() || (over && over())) throw Stopped();
  }
  void progress(std::string_view phase, double fraction) const {
    if (on_progress) on_progress(phase, fraction);
  }
  unsigned thread_count() const;
};

}  // namespace voidpath::run

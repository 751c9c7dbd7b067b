#pragma once

#include <limits>
#include <optional>

namespace voidpath::fw {

/// A contact's level without its bouncing: a change counts once the level has stayed for `quiet_s`. Pure;
/// times are the caller's, any clock that only grows.
class Debounce {
 public:
  Debounce(double quiet_s, bool active) noexcept : quiet_s_(quiet_s), settled_(active), raw_(active) {}

  /// The raw level from `at_s` on. Saying the same again changes nothing.
  void level(bool active, double at_s) noexcept {
    if (active == raw_) return;
    raw_ = active;
    since_s_ = at_s;
  }
  /// What an edge tells although its end was not seen: a level that came and went in between starts the wait
  /// anew.
  void edge(bool active, double at_s) noexcept {
    if (active == raw_) since_s_ = at_s;
    level(active, at_s);
  }
  /// The new settled level, once for each change that has lasted by `now_s`.
  std::optional<bool> settle(double now_s) noexcept {
    if (raw_ == settled_ || now_s < deadline()) return std::nullopt;
    settled_ = raw_;
    return settled_;
  }
  bool settled() const noexcept { return settled_; }
  /// When settle() may have something to tell; infinity: nothing is under way.
  double deadline() const noexcept {
    return raw_ == settled_ ? std::numeric_limits<double>::infinity() : since_s_ + quiet_s_;
  }

 private:
  double quiet_s_;
  bool settled_;
  bool raw_;
  double since_s_ = 0;
};

}  // namespace voidpath::fw

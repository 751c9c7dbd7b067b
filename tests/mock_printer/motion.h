#pragma once

#include "tests/mock_printer/planner.h"

#include <cstdint>

/// The planner and the stepper that empties it, on the printer's clock (s).
namespace voidpath::test::mock {

class Motion {
 public:
  Motion(const MotionSettings& settings, std::size_t ring) : planner_(settings, ring) {}

  const Planner& planner() const { return planner_; }
  MotionSettings& settings() { return planner_.settings(); }
  bool full() const { return planner_.full(); }
  /// Nothing queued, nothing moving.
  bool drained() const { return planner_.empty(); }

  /// Not while full.
  void add_move(double now, const Axes& target, double feed, double flow);
  void set_position(const Axes& position) { planner_.set_position(position); }
  void set_e_position(double position) { planner_.set_e_position(position); }
  /// Ends blocks whose time is over and starts what is due. Call at every `next_event` and after adding.
  void update(double now);
  /// When `update` has something to do next, infinity when never.
  double next_event() const;
  /// Drops everything at once; the queue then ends where the machine stands.
  void quick_stop(double now);
  /// Where the steppers are, steps.
  std::array<double, kAxes> steps_at(double now) const;

  /// Time during which blocks were executed, s.
  double moving_seconds() const { return moving_; }
  std::uint64_t blocks() const { return blocks_; }
  /// When the first block began and the last one ended, s.
  double first_start() const { return first_start_; }
  double last_end() const { return last_end_; }
  /// The steppers' count is set to the position the planner believes in (after homing).
  void align_steps();

 private:
  Planner planner_;
  bool running_ = false;
  double block_start_ = 0, block_end_ = 0;
  double deliver_at_ = 0;
  double moving_ = 0;
  double first_start_ = -1, last_end_ = 0;
  std::uint64_t blocks_ = 0;
  std::array<double, kAxes> done_steps_{};
};

/// With fewer blocks than this queued and nothing running, the stepper waits for more...
inline constexpr std::size_t kBlocksToStart = 3;
/// ...but not longer than this, s.
inline constexpr double kFirstBlockDelay = 0.100;

}  // namespace voidpath::test::mock

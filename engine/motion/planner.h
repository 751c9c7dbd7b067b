#pragma once

#include "engine/motion/block.h"
#include "engine/motion/junction.h"
#include "engine/motion/limits.h"
#include "engine/motion/lookahead.h"
#include "engine/motion/move.h"

#include <array>
#include <cstdint>
#include <optional>

namespace voidpath::motion {

/// What is known of a line that is a chord of an arc (PlannerHints).
struct Chord {
  float radius_d = 0;      ///< 0: not known, or not joined to a chord before it
  float safe_exit_v2 = 0;  ///< from which the rest of the arc suffices to stop
};

/// Marlin 2.x's planner and stepper on a clock of their own.
///
/// Symbols and suffixes: move.h. One call a command, in the order the firmware would run them; the clock
/// stands for the firmware's main loop and moves on only when that has to wait: for a free block, for a full
/// stop, or for a line that arrives late. Blocks are reported when the stepper takes them, which is after
/// the calls for about fifteen later lines.
///
/// Reproduced: step rounding; lines below six steps left to the next; junction deviation or classic jerk;
/// acceleration by kind of move and axis; feed limits; slowdown of short lines while the buffer is draining;
/// up to 100 ms of waiting for company at the first moves; bounded look-ahead; the stepper's arithmetic.
/// Source: Marlin bugfix-2.1.x of January 2023, planner.cpp (_buffer_steps, _populate_block, recalculate) and
/// stepper.cpp (block_phase_isr).
///
/// Copyable: a copy goes on independently and reports to the same listener until told otherwise.
/// Not thread-safe. Inputs that no machine could mean (NaN, metres) are clamped, never trusted.
class Planner {
 public:
  /// `listener` may be null and must outlive the planner.
  explicit Planner(const MachineLimits& limits, BlockListener* listener = nullptr);

  const MachineLimits& limits() const { return limits_; }
  /// Limits for lines to come (M201, M203, M204, M205, M92). Values that are not positive keep the old one
  /// where the firmware needs them positive.
  void set_limits(const MachineLimits& limits);
  void set_listener(BlockListener* listener) { listener_ = listener; }
  /// M221, 1 = 100 %.
  void set_flow(float ratio) { flow_r_ = ratio; }

  /// A straight line. False: shorter than six steps on every axis, left to the next line.
  bool line_to(const Move& move) { return queue(move, {}); }
  /// One chord of an arc.
  bool chord_to(const Move& move, const Chord& chord) { return queue(move, chord); }
  /// G92 for one axis: renames the present position; the queue goes on.
  void set_position(Axis axis, float position_d);
  /// As set_position for every axis at a standstill (homing): no queue slot.
  void reset_position(const AxisFloats& position_d);

  /// Runs everything queued and waits until it is done (M400).
  void finish();
  /// finish(), then stands still (G4).
  void dwell(double seconds);
  /// A line came in not before this time.
  void wait_until(double time_t);

  /// Main loop's clock, s.
  double now() const { return now_t_; }
  std::size_t queued() const { return queue_.count(); }
  /// Both are in the midst of the same blocks, the clock aside: given the same commands at once they will
  /// take the same time from here on.
  bool plans_like(const Planner& other) const;

 private:
  struct AxisTravel;
  bool queue(const Move& move, const Chord& chord);
  void plan_speed(Block& block, float feed_v, AxisTravel& travel) const;
  void plan_acceleration(Block& block) const;
  void plan_junction(Block& block, const AxisTravel& travel, float radius_d);
  std::array<std::int32_t, 4> to_steps(const AxisFloats& position_d) const;
  void enqueue(const Block& block);
  void wait_for_slot();
  void run_stepper(double until_t);
  double next_event_t() const;
  void start_tail(double start_t);

  MachineLimits limits_;
  BlockListener* listener_;
  AxisFloats steps_per_d_{};
  AxisFloats d_per_step_{};
  AxisFloats max_v_{};
  AxisFloats max_a_{};
  AxisFloats jerk_v_{};
  std::array<std::uint32_t, 4> max_accel_steps_{};

  Lookahead queue_;
  std::array<std::int32_t, 4> position_{};  ///< of the last line planned, steps
  float flow_r_ = 1;
  AxisFloats last_unit_{};
  JerkState last_;

  double now_t_ = 0;
  double busy_end_t_ = 0;
  double idle_from_t_ = 0;     ///< the stepper has polled an empty queue since then
  double first_queued_t_ = 0;  ///< when the queue stopped being empty
  double ready_t_ = 0;         ///< when it first held kStartCount blocks
};

}  // namespace voidpath::motion

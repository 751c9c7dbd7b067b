#pragma once

#include "tests/mock_printer/motion_settings.h"

#include <cstdint>
#include <vector>

/// The firmware's planner: a bounded queue of blocks, corner speeds, look-ahead in both directions, and the
/// trapezoid of each block in whole steps. It knows no time; the stepper takes blocks out at its own pace.
///
/// Ring, by ever-growing sequence numbers: tail <= nonbusy <= head. [tail, nonbusy) is what the stepper
/// executes (at most one block), [nonbusy, head) can still be replanned.
namespace voidpath::test::mock {

struct Block {
  std::array<std::int32_t, kAxes> steps{};  ///< signed
  std::uint32_t step_events = 0;            ///< steps of the dominant axis; 0: a position mark, takes no time
  double length = 0;                        ///< mm; of E when nothing else moves
  double nominal_speed = 0;                 ///< mm/s
  double acceleration = 0;                  ///< mm/s²
  double entry_speed2 = 0;                  ///< mm²/s²
  double max_entry_speed2 = 0;              ///< mm²/s²
  std::uint32_t nominal_rate = 0;           ///< steps/s
  std::uint32_t initial_rate = 0;
  std::uint32_t final_rate = 0;
  std::uint32_t acceleration_rate = 0;  ///< steps/s²
  std::uint32_t accelerate_until = 0;   ///< steps
  std::uint32_t decelerate_after = 0;   ///< steps
  bool is_move() const { return step_events > 0; }
};

/// Seconds the stepper needs for a block: one interval a step, rates in whole steps/s, where deceleration
/// starts with the rate the acceleration really reached and so ends before the block does.
double stepping_seconds(const Block& block);

/// Below this rate the firmware's step timer would overflow, steps/s.
inline constexpr std::uint32_t kMinimalRate = 120;
/// The speed at which motion starts from rest and ends, mm/s.
inline constexpr double kMinimumPlannerSpeed = 0.05;
/// The same in Sailfish, mm/s.
inline constexpr double kSailfishMinimumSpeed = 2;
/// A move with fewer steps than this on every axis is not queued; the next one takes its length along.
inline constexpr std::int32_t kMinStepsPerSegment = 6;

class Planner {
 public:
  /// A ring of n holds n − 1 blocks.
  explicit Planner(const MotionSettings& settings, std::size_t ring = 16);

  MotionSettings& settings() { return settings_; }
  const MotionSettings& settings() const { return settings_; }

  bool full() const { return head_ - tail_ == ring_.size() - 1; }
  bool empty() const { return head_ == tail_; }
  std::size_t queued() const { return head_ - tail_; }
  std::size_t free() const { return ring_.size() - 1 - queued(); }

  /// Queues a straight move to `target` (mm, planner's frame) at `feed` mm/s along the path. Not while full.
  /// False when it was too short to queue. `flow` scales E.
  bool add_move(const Axes& target, double feed, double flow = 1);
  /// Declares where the planner is (mm) without moving; while blocks are queued it costs a place in the ring.
  void set_position(const Axes& position);
  /// The same for E alone.
  void set_e_position(double position);
  /// Where the queue ends, mm.
  Axes position() const;

  /// The next block to execute, or null. It becomes busy: nothing about it changes any more.
  const Block* take();
  /// The busy block, or null.
  const Block* busy() const { return nonbusy_ > tail_ ? &at(tail_) : nullptr; }
  /// The busy block is done.
  void release();
  /// Drops everything, the busy block included. The caller then sets the position.
  void clear();

 private:
  Block& at(std::uint64_t seq) { return ring_[seq % ring_.size()]; }
  const Block& at(std::uint64_t seq) const { return ring_[seq % ring_.size()]; }
  void mark_position();
  void limit_speed(Block& block, double feed, const Axes& mm, Axes& speed) const;
  void limit_acceleration(Block& block) const;
  double junction_speed2(const Block& block, const Axes& direction, bool from_rest) const;
  double sailfish_speed2(const Block& block, const Axes& speed, bool from_rest);
  double jerk_speed2(const Block& block, const Axes& speed, bool from_rest);
  double acceleration_along(double limit, const Axes& direction) const;
  void look_ahead();
  void shape(std::uint64_t seq, double exit_speed);

  MotionSettings settings_;
  std::vector<Block> ring_;
  std::uint64_t tail_ = 0, nonbusy_ = 0, head_ = 0;
  std::array<std::int32_t, kAxes> steps_{};  ///< position where the queue ends
  Axes previous_direction_{};
  Axes previous_speed_{};             ///< mm/s per axis
  double previous_nominal_ = 0;       ///< mm/s
  double previous_safe_speed_ = 0;    ///< mm/s, classic jerk only
  std::vector<double> shaped_exit_;   ///< mm/s: exit speed each slot's trapezoid was made for
  std::vector<double> shaped_entry_;  ///< mm/s
};

}  // namespace voidpath::test::mock

#pragma once

#include "engine/motion/block.h"

#include <cstddef>
#include <vector>

/// The firmware's block buffer and its speed planning.
///
/// Blocks enter at the head and leave at the tail. `planned` is the first block whose entry speed may still
/// change: everything before it is bracketed by speeds that cannot get better. Reverse pass: from the newest
/// block back to `planned`, each entry as fast as braking over the block allows. Forward pass: from `planned`
/// on, each entry no faster than accelerating over the block before allows. A block the stepper has taken
/// ("busy") is final, its exit speed included, hence the entry speed of the one after it.
/// Source: Marlin planner.cpp, Planner::reverse_pass, forward_pass, get_current_block.
namespace voidpath::motion {

class Lookahead {
 public:
  /// `slots` as in the firmware's configuration: one less is usable.
  explicit Lookahead(int slots);

  bool empty() const { return count_ == 0; }
  bool full() const { return count_ + 1 >= ring_.size(); }
  std::size_t count() const { return count_; }
  bool busy() const { return busy_; }
  /// Blocks that can still be altered.
  std::size_t waiting() const { return count_ - (busy_ ? 1 : 0); }

  /// Appends a block and plans again. Not when full.
  void push(const Block& block);
  /// The stepper takes the tail: its speeds are final from here on.
  void take();
  const Block& tail() const { return ring_[tail_]; }
  /// Exit speed of the tail as planned now, mm²/s².
  float tail_exit_v2() const;
  /// The stepper is done with the tail.
  void pop();
  /// Both hold the same lines with the same speeds and freedom: they will plan alike from here on.
  bool same_plan(const Lookahead& other) const;

 private:
  std::size_t after(std::size_t i) const { return i + 1 == ring_.size() ? 0 : i + 1; }
  std::size_t before(std::size_t i) const { return (i == 0 ? ring_.size() : i) - 1; }
  std::size_t head() const {
    const std::size_t i = tail_ + count_;
    return i < ring_.size() ? i : i - ring_.size();
  }
  void reverse_pass();
  void forward_pass();
  bool may_follow(std::size_t previous) const { return !(busy_ && previous == tail_); }

  std::vector<Block> ring_;
  std::size_t tail_ = 0;
  std::size_t count_ = 0;
  std::size_t planned_ = 0;
  bool busy_ = false;
};

}  // namespace voidpath::motion

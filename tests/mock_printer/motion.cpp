#include "tests/mock_printer/motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::test::mock {

void Motion::add_move(double now, const Axes& target, double feed, double flow) {
  const bool was_empty = planner_.empty();
  if (planner_.add_move(target, feed, flow) && was_empty) deliver_at_ = now + kFirstBlockDelay;
}

void Motion::update(double now) {
  for (;;) {
    double start = now;
    if (running_) {
      if (block_end_ > now) return;
      const Block* done = planner_.busy();
      for (std::size_t i = 0; i < kAxes; ++i) done_steps_[i] += done->steps[i];
      planner_.release();
      running_ = false;
      start = last_end_ = block_end_;
    } else if (!planner_.settings().sailfish && planner_.queued() < kBlocksToStart && now < deliver_at_) {
      return;
    }
    const Block* block = planner_.take();
    if (block == nullptr) return;
    const double seconds = stepping_seconds(*block);
    if (first_start_ < 0) first_start_ = start;
    block_start_ = start;
    block_end_ = start + seconds;
    moving_ += seconds;
    ++blocks_;
    running_ = true;
  }
}

double Motion::next_event() const {
  if (running_) return block_end_;
  if (!planner_.empty()) return deliver_at_;
  return std::numeric_limits<double>::infinity();
}

std::array<double, kAxes> Motion::steps_at(double now) const {
  std::array<double, kAxes> steps = done_steps_;
  if (!running_) return steps;
  // Within a block the distance is taken as proportional to time: good enough for a report.
  const double share = std::clamp((now - block_start_) / (block_end_ - block_start_), 0.0, 1.0);
  for (std::size_t i = 0; i < kAxes; ++i) steps[i] += std::round(planner_.busy()->steps[i] * share);
  return steps;
}

void Motion::quick_stop(double now) {
  done_steps_ = steps_at(now);
  if (running_) {
    moving_ -= block_end_ - now;
    last_end_ = now;
  }
  running_ = false;
  planner_.clear();
  Axes position{};
  for (std::size_t i = 0; i < kAxes; ++i) position[i] = done_steps_[i] / settings().steps_per_mm[i];
  planner_.set_position(position);
}

void Motion::align_steps() {
  const Axes position = planner_.position();
  for (std::size_t i = 0; i < kAxes; ++i)
    done_steps_[i] = std::round(position[i] * settings().steps_per_mm[i]);
}

}  // namespace voidpath::test::mock

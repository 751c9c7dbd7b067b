#include "engine/motion/lookahead.h"

#include "engine/motion/junction.h"

#include <algorithm>
#include <cassert>

namespace voidpath::motion {
namespace {

constexpr float kMinPlannerV2 = kMinPlannerV * kMinPlannerV;

/// Speed before `length_d` of braking at `accel_a` down to `end_v2`; as well after speeding up from it.
float reachable_v2(float accel_a, float end_v2, float length_d) { return end_v2 + 2 * accel_a * length_d; }

/// Exit speed of the newest block.
float last_exit_v2(const Block& block) { return std::max(block.safe_exit_v2, kMinPlannerV2); }

void plan_entry(Block& current, const Block* next) {
  if (current.entry_v2 == current.max_entry_v2 && !(next != nullptr && next->changed)) return;
  const float exit_v2 = next != nullptr ? next->entry_v2 : last_exit_v2(current);
  const float entry_v2 =
      current.nominal_length
          ? current.max_entry_v2
          : std::min(current.max_entry_v2, reachable_v2(current.accel_a, exit_v2, current.length_d));
  if (entry_v2 != current.entry_v2) {
    current.entry_v2 = entry_v2;
    current.changed = true;
  }
}

}  // namespace

Lookahead::Lookahead(int slots) : ring_(static_cast<std::size_t>(std::max(slots, 2))) {}

void Lookahead::push(const Block& block) {
  assert(!full());
  const std::size_t at = head();
  ring_[at] = block;
  if (count_ == 0) planned_ = at;
  ++count_;
  if (block.sync) return;
  ring_[at].nominal_length =
      block.nominal_v * block.nominal_v <= reachable_v2(block.accel_a, kMinPlannerV2, block.length_d);
  ring_[at].entry_v2 = kMinPlannerV2;
  if (at == planned_) return;
  reverse_pass();
  forward_pass();
}

void Lookahead::reverse_pass() {
  const Block* next = nullptr;
  for (std::size_t i = before(head()); i != planned_; i = before(i)) {
    Block& current = ring_[i];
    if (current.sync) continue;
    current.changed = false;
    plan_entry(current, next);
    next = &current;
  }
}

void Lookahead::forward_pass() {
  const Block* previous = nullptr;
  std::size_t previous_at = 0;
  const std::size_t end = head();
  for (std::size_t i = planned_; i != end; i = after(i)) {
    Block& current = ring_[i];
    if (current.sync) continue;
    if (previous != nullptr && may_follow(previous_at)) {
      if (!previous->nominal_length && previous->entry_v2 < current.entry_v2) {
        const float entry_v2 = reachable_v2(previous->accel_a, previous->entry_v2, previous->length_d);
        if (entry_v2 < current.entry_v2) {
          current.entry_v2 = entry_v2;
          planned_ = i;
        }
      }
      if (current.entry_v2 == current.max_entry_v2) planned_ = i;
    }
    previous = &current;
    previous_at = i;
  }
}

void Lookahead::take() {
  assert(!empty() && !busy_);
  busy_ = true;
  if (planned_ == tail_) planned_ = after(tail_);
}

float Lookahead::tail_exit_v2() const {
  std::size_t i = tail_;
  for (std::size_t n = 1; n < count_; ++n) {
    i = after(i);
    if (!ring_[i].sync) return ring_[i].entry_v2;
  }
  return last_exit_v2(tail());
}

bool Lookahead::same_plan(const Lookahead& other) const {
  if (count_ != other.count_ || busy_ != other.busy_ || ring_.size() != other.ring_.size()) return false;
  std::size_t i = tail_;
  std::size_t j = other.tail_;
  for (std::size_t n = 0; n < count_; ++n) {
    const Block& a = ring_[i];
    const Block& b = other.ring_[j];
    if (a.tag != b.tag || a.sync != b.sync || a.entry_v2 != b.entry_v2 || a.nominal_v != b.nominal_v ||
        a.max_entry_v2 != b.max_entry_v2 || (i == planned_) != (j == other.planned_)) {
      return false;
    }
    i = after(i);
    j = other.after(j);
  }
  return true;
}

void Lookahead::pop() {
  assert(busy_);
  busy_ = false;
  tail_ = after(tail_);
  --count_;
}

}  // namespace voidpath::motion

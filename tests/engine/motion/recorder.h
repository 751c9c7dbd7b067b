#pragma once

#include "engine/motion/planner.h"

#include <vector>

namespace voidpath::test {

/// Keeps what the planner reported.
struct Recorder : motion::BlockListener {
  struct Entry {
    motion::Block block;
    double start_t;
    double duration_t;
    double entry_v;
    double exit_v;
  };
  std::vector<Entry> entries;

  void on_block(const motion::TimedBlock& timed) override {
    entries.push_back({*timed.block, timed.start_t, timed.duration_t, static_cast<double>(timed.entry_v),
                       static_cast<double>(timed.exit_v)});
  }
  double busy_t() const {
    double sum = 0;
    for (const Entry& entry : entries) sum += entry.duration_t;
    return sum;
  }
};

/// Limits that make arithmetic by hand easy: fine steps, equal axes, continuous trapezoids.
inline motion::MachineLimits plain_limits() {
  motion::MachineLimits limits;
  limits.stepping = motion::Stepping::ideal;
  limits.steps_per_mm = {1000, 1000, 1000, 1000};
  limits.max_speed_mm_s = {500, 500, 500, 500};
  limits.max_acceleration_mm_s2 = {1000, 1000, 1000, 1000};
  limits.print_acceleration_mm_s2 = limits.travel_acceleration_mm_s2 = limits.retract_acceleration_mm_s2 =
      1000;
  limits.junction_deviation_mm = 0.02;
  limits.baud = 0;
  return limits;
}

inline motion::Move move_to(double x, double y, double feed_v, double e = 0, double z = 0,
                            std::uint64_t tag = 0) {
  return {{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(e)},
          static_cast<float>(feed_v),
          tag};
}

}  // namespace voidpath::test

#pragma once

#include "engine/motion/move.h"

#include <array>
#include <cstdint>

namespace voidpath::motion {

enum class MoveKind : std::uint8_t {
  extrude,  ///< axes move and filament goes forward
  travel,   ///< axes move, filament rests or is drawn back
  filament  ///< the filament alone
};

/// What the planner holds for one line: a straight piece with a trapezoidal speed profile.
struct Block {
  bool sync = false;  ///< a position change riding along in the queue (G92): takes a slot, no time
  /// The speed profile fits whatever the neighbours do: top speed to rest within its length.
  bool nominal_length = false;
  bool changed = false;  ///< entry speed changed in the pass under way
  MoveKind kind = MoveKind::extrude;
  std::array<std::uint32_t, 4> steps{};
  std::uint32_t step_count = 0;  ///< of the axis with most steps
  std::uint32_t nominal_rate = 0;
  std::uint32_t accel_steps = 0;  ///< steps/s²
  float length_d = 0;
  float nominal_v = 0;
  float accel_a = 0;
  float entry_v2 = 0;
  float max_entry_v2 = 0;
  float safe_exit_v2 = 0;  ///< exit speed while it is the newest block; at least the minimum speed
  float e_d = 0;           ///< signed filament length
  std::uint64_t tag = 0;
};

/// A block whose speeds are final, as the stepper starts it.
struct TimedBlock {
  const Block* block = nullptr;
  double start_t = 0;
  double duration_t = 0;
  float entry_v = 0;
  float exit_v = 0;
};

/// Receives each block once its time is final: when the stepper takes it, in order.
class BlockListener {
 public:
  virtual ~BlockListener() = default;
  virtual void on_block(const TimedBlock& timed) = 0;
};

}  // namespace voidpath::motion

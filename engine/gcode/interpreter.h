#pragma once

#include "engine/gcode/reader.h"
#include "engine/motion/wire.h"

#include <cstdint>
#include <string>
#include <vector>

namespace voidpath::gcode {

/// What one command did, for whoever counts.
struct Effect {
  enum class Kind { none, move, dwell, heating_wait, homing };
  Kind kind = Kind::none;
  float e_d = 0;            ///< filament moved, mm
  bool moves_axes = false;  ///< x, y or z changed
  bool moves_xy = false;
  bool flat = true;    ///< z did not change
  double seconds = 0;  ///< of a dwell or of homing
};

/// The firmware's modal state: turns commands into planner calls as Marlin 2.x does. Positions are single
/// precision as in the firmware, so that sums of relative filament moves round alike.
class Interpreter {
 public:
  explicit Interpreter(motion::WiredPlanner& planner) : planner_(planner) {}

  /// Obeys one command; `tag` goes with its blocks.
  Effect run(const Command& command, std::uint64_t tag);

  float z() const { return position_[2]; }
  /// M201, M203, M204 or M205 have changed the planner's limits.
  bool limits_changed() const { return limits_changed_; }
  /// Homing that came before any other move stood outside of the planner's clock.
  bool moved() const { return moved_; }
  const std::vector<std::string>& notes() const { return notes_; }

 private:
  using Axes = motion::AxisFloats;

  Effect run_g(const Command& command, std::uint64_t tag);
  Effect run_m(const Command& command);
  Effect line(const Command& command, std::uint64_t tag);
  Effect arc(const Command& command, std::uint64_t tag, bool clockwise);
  Effect finish_move(const Axes& target, Effect effect);
  Effect retract(bool back, std::uint64_t tag);
  Effect dwell(const Command& command);
  Effect home(const Command& command);
  Effect home_far(const Command& command);
  double end_mm(std::size_t axis) const;
  bool is_s3g() const { return planner_.limits().firmware == motion::Firmware::s3g; }
  void set_position(const Command& command);
  void set_limits(const Command& command);
  Axes target_of(const Command& command);
  Effect effect_of(const Axes& target) const;
  /// MMS_SCALED: multiplied in this order, 30 mm/s comes out a rounding below 30, and step rates with it.
  float feed_v() const { return feed_mm_min_ / 60.0F * 0.01F * feed_percent_; }
  void note(const std::string& text);

  motion::WiredPlanner& planner_;
  Axes position_{};
  float unit_mm_ = 1;
  float feed_mm_min_ = 1500;  ///< before the first F
  float feed_percent_ = 100;  ///< M220
  bool relative_ = false;
  bool relative_e_ = false;
  bool moved_ = false;
  bool known_[3] = {false, false, false};  ///< homed, so the way home is known
  bool limits_changed_ = false;
  float retract_d_ = 3;  ///< M207 S, as the firmware starts
  float retract_feed_mm_min_ = 2700;
  bool retracted_ = false;
  std::vector<std::string> notes_;
};

}  // namespace voidpath::gcode

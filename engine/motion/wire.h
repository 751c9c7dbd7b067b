#pragma once

#include "engine/motion/arc.h"
#include "engine/motion/planner.h"

#include <cstddef>
#include <deque>
#include <optional>
#include <string_view>

/// The serial line that feeds the planner.
///
/// A line costs ten bits a byte at the line's rate. The host keeps lines in flight as long as what the
/// firmware has not yet confirmed fits its receive buffer; the firmware confirms a line once it has been
/// planned. So while the block buffer is full the wire is ahead, and only lines shorter than the wire can
/// bring make the planner wait.
namespace voidpath::motion {

/// When each line has arrived. Feed it every line in order.
class SerialLine {
 public:
  /// `baud` 0 or less: lines arrive as soon as they are wanted.
  SerialLine(double baud, int rx_bytes);

  /// Seconds at which a line of that many bytes, frame included, is complete.
  double arrival(std::size_t bytes);
  /// The line whose arrival was asked last has been planned.
  void confirmed(double time_t);

 private:
  struct Pending {
    std::size_t bytes;
    double confirmed_t;
  };
  double byte_t_;
  std::size_t window_bytes_;
  std::size_t in_flight_ = 0;
  double free_t_ = 0;  ///< the wire has sent everything before
  std::deque<Pending> pending_;
};

/// Bytes that a command fills on the wire, and of the firmware's buffer, as line `number`:
/// "N12 G1 X1.5*34\n".
std::size_t framed_bytes(std::string_view command, std::size_t number, LineFormat format);

/// A planner behind a serial line, and beside it, whenever a late line has made a difference, the same
/// planner fed without delay: the difference of their clocks is what the line costs.
class WiredPlanner {
 public:
  WiredPlanner(const MachineLimits& limits, BlockListener* listener);

  const MachineLimits& limits() const { return wired_.limits(); }
  /// The next command comes in a line of its own.
  void receive(std::string_view command);
  /// The command has been obeyed.
  void confirm();

  void set_limits(const MachineLimits& limits);
  void set_flow(float ratio);
  void line_to(const Move& move);
  void arc_to(const Arc& arc);
  void set_position(Axis axis, float position_d);
  void reset_position(const AxisFloats& position_d);
  void finish();
  void dwell(double seconds);

  double now() const { return wired_.now(); }
  /// Seconds lost to the line so far. After finish().
  double serial_limited() const;

 private:
  void try_to_join();

  Planner wired_;
  std::optional<Planner> ideal_;
  SerialLine line_;
  std::size_t number_ = 0;
  std::size_t since_join_ = 0;
  double lost_t_ = 0;
};

}  // namespace voidpath::motion

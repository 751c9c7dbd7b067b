#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

/// What every mock firmware is to the program around it: bytes in, bytes out, on a clock of its own that
/// moves only when told. Deterministic; no threads, no files, no waiting.
namespace voidpath::test::mock {

struct Statistics;

class Firmware {
 public:
  virtual ~Firmware() = default;

  /// The host writes bytes now.
  virtual void feed(std::string_view bytes) = 0;
  /// Lets the clock run to `time` (s, never backwards) and does all that is due until then.
  virtual void advance_to(double time) = 0;
  virtual double now() const = 0;
  /// When something happens without the host doing anything; infinity when nothing will.
  virtual double next_event() const = 0;
  /// What has reached the host by now.
  virtual std::string take_output() = 0;
  /// True while the printer has answered everything it got and could use more: the moment at which an
  /// accelerated clock must stand still for the host.
  virtual bool waits_for_host() const = 0;
  /// Nothing queued to move, nothing moving.
  virtual bool drained() const = 0;
  /// Grows with each command that carries the print on.
  virtual std::uint64_t progress() const = 0;
  /// Each command as it begins to execute.
  virtual void on_command(std::function<void(std::string_view)> callback) = 0;
  /// Power-on or reset.
  virtual void reset() = 0;
  /// Seconds for which the cable is to be out, once after such a fault fired.
  virtual std::optional<double> take_unplug() = 0;
  virtual Statistics statistics() const = 0;
};

}  // namespace voidpath::test::mock

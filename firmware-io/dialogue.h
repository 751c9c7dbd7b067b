#pragma once

#include "firmware-io/line_source.h"

#include <memory>
#include <string>
#include <string_view>

namespace voidpath::fw {

/// Everything between a port's bytes and the events of a printer: no thread, no I/O, no clock of its own; `t`
/// is the steady clock's time in seconds. One thread.
///
/// opened() begins; received(), elapsed() (at deadline() at the latest) and the commands drive it; output()
/// is to be written after each call; once closing() holds, the port must be closed and may be opened again.
class Dialogue {
 public:
  virtual ~Dialogue() = default;

  virtual void opened(double t) = 0;
  virtual void received(std::string_view bytes, double t) = 0;
  virtual void elapsed(double t) = 0;
  virtual double deadline() const noexcept = 0;
  /// The port is gone, or could not be opened. Reported once for each reason.
  virtual void lost(const std::string& reason) = 0;

  virtual void print(std::unique_ptr<LineSource> source, double t) = 0;
  virtual void pause() = 0;
  virtual void resume(double t) = 0;
  virtual void cancel(const std::string& reason, double t) = 0;
  virtual void halt(const std::string& reason, double t) = 0;
  /// Since opened(): the printer has answered to it.
  virtual bool halt_heard() const noexcept = 0;
  virtual void command(const std::string& text, double t) = 0;
  /// Ends a print with the heaters first. Afterwards finished() tells when that is through, and an emergency
  /// stop heard.
  virtual void shut_down(double t) = 0;
  virtual bool finished() const noexcept = 0;
  /// What ends the print has turned the heaters off.
  virtual bool cold() const noexcept { return finished(); }

  virtual std::string& output() noexcept = 0;
  /// True once after halt(): what was written before and is still on its way should be thrown away.
  virtual bool take_urgent() noexcept = 0;
  virtual bool closing() const noexcept = 0;
  /// Until then bytes that come may be left lying: there is enough on its way, and fewer awakenings cost
  /// less.
  virtual double unhurried_until() const noexcept { return 0; }
  /// Such a rest was to end at `until` and ended at `t`: so late the thread awakes.
  virtual void rested(double /*until*/, double /*t*/) noexcept {}
};

}  // namespace voidpath::fw

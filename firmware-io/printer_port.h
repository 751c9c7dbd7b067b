#pragma once

#include "firmware-io/clock.h"
#include "firmware-io/event.h"
#include "firmware-io/line_source.h"
#include "firmware-io/s3g/machine.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace voidpath::fw {

struct PortOptions {
  std::string port;  ///< tty path, a pty or a by-id link included
  int baud = 115200;
  int rx_bytes = 128;    ///< the firmware's receive buffer: rx_bytes - 1 unacknowledged bytes may be out
  bool meatpack = true;  ///< lines go packed when the firmware offers it
  int keepalive_s = 2;   ///< a Marlin at a long command is to say so this often; 0: as it is set
  /// False: the port is closed without a hang-up, so that opening it again restarts no board.
  bool reset_on_connect = true;
  double boot_wait_s = 3;           ///< how long to wait for "start" after opening
  double reconnect_s = 2;           ///< how often a missing port is tried again
  std::optional<s3g::Machine> s3g;  ///< of a MakerBot; empty: Marlin
  /// Sent after a cancel, before heaters off (lift, park), written as in a file, in millimetres; by a
  /// MakerBot also when a print fails on its file.
  std::vector<std::string> cancel_gcode;
};

/// One printer. Starts its own thread, which connects, reconnects and streams; all calls below only post
/// to it and return at once, from any thread.
/// Events come from that thread, in order; the handler must be quick and must not throw.
class PrinterPort {
 public:
  using Handler = std::function<void(const Event&)>;
  virtual ~PrinterPort() = default;

  /// Streams the source from its first line. Only while connected and idle; otherwise PrintFailed.
  virtual void print(std::unique_ptr<LineSource> source) = 0;
  /// Stops feeding after the lines in flight; heaters stay on.
  virtual void pause() = 0;
  virtual void resume() = 0;
  /// Ends the print: stops feeding, runs cancel_gcode, heaters and fan off, motors free.
  virtual void cancel(std::string reason) = 0;
  /// Emergency: M112, or what S3G has for it, ahead of everything queued. Waits on no lock. Until the printer
  /// has answered to it, it is the first that goes out whenever the port is opened again.
  virtual void halt(std::string reason) = 0;
  /// Not that: a person has seen to the printer.
  virtual void forget_halt() = 0;
  /// Lines of the user's, sent between the print's own; their answers come as Message.
  virtual void command(std::string text) = 0;
  /// The last lines each way, oldest first, as "> sent" and "< received" with their times.
  virtual std::vector<std::string> dialogue() const = 0;
};

/// A Marlin-class printer behind a serial port. Never throws: a port that cannot be opened is reported as
/// Disconnected and tried again. Destruction ends a running print safely (heaters off) and joins the thread.
std::unique_ptr<PrinterPort> open_marlin(PortOptions options, std::shared_ptr<const Clock> clock,
                                         PrinterPort::Handler handler);

/// A MakerBot or Sailfish printer, as options.s3g describes it, spoken to in S3G. The rest as open_marlin().
std::unique_ptr<PrinterPort> open_s3g(PortOptions options, std::shared_ptr<const Clock> clock,
                                      PrinterPort::Handler handler);

/// Reads a G-code file line by line; strips comments, blanks and what a firmware would choke on.
/// Throws std::runtime_error naming the file.
std::unique_ptr<LineSource> open_gcode_file(const std::string& file);

}  // namespace voidpath::fw

#pragma once

#include "firmware-io/marlin/driver.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/transport/transport.h"

#include <functional>
#include <memory>

namespace voidpath::fw::marlin {

struct SessionOptions {
  DriverOptions driver;
  double reconnect_s = 2;
  /// So long a running print may take to end in an orderly way on destruction; then it is halted.
  double shutdown_s = 5;
};

/// A Marlin-class printer behind any transport. `open` is called on the session's thread, again and again
/// while there is no port. See PrinterPort for all else.
std::unique_ptr<PrinterPort> start_session(SessionOptions options, OpenTransport open,
                                           std::shared_ptr<const Clock> clock, PrinterPort::Handler handler);

}  // namespace voidpath::fw::marlin

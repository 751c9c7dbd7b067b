#pragma once

#include "firmware-io/dialogue.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/transport/transport.h"

#include <functional>
#include <memory>

namespace voidpath::fw {

struct SessionTiming {
  double reconnect_s = 2;
  /// So long a running print may take to end in an orderly way on destruction; then it is halted.
  double shutdown_s = 5;
};

/// Makes the dialogue; clock and recorder outlive it.
using MakeDialogue =
    std::function<std::unique_ptr<Dialogue>(const Clock&, FlightRecorder&, PrinterPort::Handler)>;

/// A printer behind any transport. `open` is called on the session's thread, again and again while there is
/// no port. See PrinterPort for all else.
std::unique_ptr<PrinterPort> start_session(SessionTiming timing, OpenTransport open,
                                           std::shared_ptr<const Clock> clock, PrinterPort::Handler handler,
                                           const MakeDialogue& make);

}  // namespace voidpath::fw

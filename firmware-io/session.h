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
  double shutdown_s = 5;  ///< at most so long a running print is ended in an orderly way on destruction
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

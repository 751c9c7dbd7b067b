#pragma once

#include "firmware-io/s3g/driver.h"
#include "firmware-io/session.h"

namespace voidpath::fw::s3g {

/// A MakerBot behind any transport.
std::unique_ptr<PrinterPort> start_session(DriverOptions options, SessionTiming timing, OpenTransport open,
                                           std::shared_ptr<const Clock> clock, PrinterPort::Handler handler);

}  // namespace voidpath::fw::s3g

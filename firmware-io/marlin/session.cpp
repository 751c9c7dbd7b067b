#include "firmware-io/marlin/session.h"

#include "firmware-io/session.h"
#include "firmware-io/transport/serial_port.h"

#include <utility>

namespace voidpath::fw::marlin {
namespace {

// A wire byte is 10 bits: start, 8 data, stop.
constexpr double kBitsPerByte = 10;

}  // namespace

std::unique_ptr<PrinterPort> start_session(SessionOptions options, OpenTransport open,
                                           std::shared_ptr<const Clock> clock, PrinterPort::Handler handler) {
  const auto make = [driver = std::move(options.driver)](const Clock& stamp, FlightRecorder& recorder,
                                                         PrinterPort::Handler to) {
    return std::make_unique<Driver>(driver, stamp, recorder, std::move(to));
  };
  return fw::start_session({options.reconnect_s, options.shutdown_s}, std::move(open), std::move(clock),
                           std::move(handler), make);
}

}  // namespace voidpath::fw::marlin

namespace voidpath::fw {

std::unique_ptr<PrinterPort> open_marlin(PortOptions options, std::shared_ptr<const Clock> clock,
                                         PrinterPort::Handler handler) {
  marlin::SessionOptions session;
  session.driver.window.max_bytes = options.rx_bytes - 1;
  session.driver.handshake.boot_wait_s = options.boot_wait_s;
  session.driver.byte_s = marlin::kBitsPerByte / options.baud;
  session.driver.cancel_gcode = options.cancel_gcode;
  session.driver.meatpack = options.meatpack;
  session.driver.keepalive_s = options.keepalive_s;
  session.reconnect_s = options.reconnect_s;
  auto open = [port = options.port, baud = options.baud, hang_up = options.reset_on_connect] {
    return open_serial_port(port, baud, hang_up);
  };
  return marlin::start_session(std::move(session), std::move(open), std::move(clock), std::move(handler));
}

}  // namespace voidpath::fw

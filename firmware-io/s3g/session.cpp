#include "firmware-io/s3g/session.h"

#include "firmware-io/transport/serial_port.h"

#include <utility>

namespace voidpath::fw::s3g {

std::unique_ptr<PrinterPort> start_session(DriverOptions options, SessionTiming timing, OpenTransport open,
                                           std::shared_ptr<const Clock> clock, PrinterPort::Handler handler) {
  const auto make = [driver = std::move(options)](const Clock& stamp, FlightRecorder& recorder,
                                                  PrinterPort::Handler to) {
    return std::make_unique<Driver>(driver, stamp, recorder, std::move(to));
  };
  return fw::start_session(timing, std::move(open), std::move(clock), std::move(handler), make);
}

}  // namespace voidpath::fw::s3g

namespace voidpath::fw {

std::unique_ptr<PrinterPort> open_s3g(PortOptions options, std::shared_ptr<const Clock> clock,
                                      PrinterPort::Handler handler) {
  s3g::DriverOptions driver;
  driver.machine = options.s3g.value_or(s3g::Machine{});
  driver.timing.byte_s = options.baud > 0 ? 10.0 / options.baud : 0;  // 8N1
  driver.boot_wait_s = options.boot_wait_s;
  driver.cancel_gcode = options.cancel_gcode;
  auto open = [port = options.port, baud = options.baud, hang_up = options.reset_on_connect] {
    return open_serial_port(port, baud, hang_up);
  };
  return s3g::start_session(std::move(driver), {.reconnect_s = options.reconnect_s}, std::move(open),
                            std::move(clock), std::move(handler));
}

}  // namespace voidpath::fw

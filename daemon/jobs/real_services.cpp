#include "daemon/jobs/printer.h"

namespace voidpath::daemon {

PortServices real_services() {
  return {
      [](fw::PortOptions options, std::shared_ptr<const fw::Clock> clock, fw::PrinterPort::Handler handler) {
        if (options.s3g) return fw::open_s3g(std::move(options), std::move(clock), std::move(handler));
        return fw::open_marlin(std::move(options), std::move(clock), std::move(handler));
      },
      [](const std::filesystem::path& file) { return fw::open_gcode_file(file.string()); },
      [](const config::PrinterConfig& printer) {
        return printer.clock.empty() ? fw::steady_clock() : fw::mapped_clock(printer.clock);
      }};
}

}  // namespace voidpath::daemon

#include "daemon/jobs/runner.h"

/// What the pins say, brought to the table, and what they are told.
namespace voidpath::daemon {

void Runner::attach_pins(Printer& printer) {
  const auto& pins = printer.config().pins;
  const bool any = pins.emergency_stop || pins.bed_button || pins.door || pins.filament || pins.relay ||
                   pins.led || pins.light;
  if (!any) return;
  if (s_.pins == nullptr)
    throw fw::PinError("printer " + printer.name() + " has pins, and there are none here");
  PinHooks hooks;
  hooks.halt = [&printer] { printer.halt_port("the emergency stop was pulled"); };
  hooks.stopped = [this, &printer](const std::string& reason) { halted(printer.name(), reason); };
  hooks.bed_pressed = [this, &printer] {
    try {
      bed_clear(printer.name());
    } catch (const std::exception& refused) {
      s_.log.warning("bed_button", {{"printer", printer.name()}, {"reason", refused.what()}});
    }
  };
  hooks.pause = [this, &printer](const std::string& reason) { pause_by_pin(printer, reason); };
  hooks.note = [this, &printer](const std::string& what) {
    s_.log.warning("pin", {{"printer", printer.name()}, {"what", what}});
  };
  hooks.changed = [this] {
    changed();
    want_schedule();
  };
  printer.attach(std::make_unique<PrinterPins>(s_.loop, pins, *s_.pins, printer.name(), std::move(hooks)));
}

void Runner::pause_by_pin(Printer& printer, const std::string& reason) {
  // Past the store, which may be full; the reason comes back with the printer's event.
  if (printer.busy() && !printer.paused()) printer.pause(reason);
}

bool Runner::about_to_print(const Printer& printer) const {
  if (stopping_ || printer.busy() || job_on(printer) || !printer.memory.bed_clear ||
      !printer.memory.held.empty())
    return false;
  if (printer.pins() && !printer.pins()->blocker().empty()) return false;
  for (const Job* job : queue()) {
    if (job->printer == printer.name() && queued(job->state)) return job->state == State::waiting_bed;
  }
  return false;
}

void Runner::update_pins(Printer& printer) {
  PrinterPins* pins = printer.pins();
  if (pins == nullptr) return;
  const Job* job = job_on(printer);
  Activity now;
  now.connected = printer.connected();
  now.printing = job != nullptr || printer.busy();
  now.paused = job != nullptr && job->state == State::paused;
  now.about_to_print = about_to_print(printer);
  now.bed_clear = printer.memory.bed_clear;
  now.held = !printer.memory.held.empty();
  pins->update(now);
}

void Runner::pins_of_event(Printer& printer, const fw::Event& event) {
  PrinterPins* pins = printer.pins();
  if (pins == nullptr) return;
  if (const auto* failed = std::get_if<fw::PrintFailed>(&event.what)) {
    pins->fault(failed->reason);
  } else if (const auto* down = std::get_if<fw::Disconnected>(&event.what)) {
    pins->disconnected(down->reason);
  } else if (std::holds_alternative<fw::Resumed>(event.what)) {
    // Whoever presses a button at the printer asks nobody here.
    if (const std::string why = pins->blocker(); !why.empty()) pause_by_pin(printer, why);
  } else {
    return;
  }
  want_schedule();
}

void Runner::power(const std::string& name, bool on) {
  Printer& one = printer(name);
  PrinterPins* pins = one.pins();
  if (pins == nullptr || !pins->has_power()) throw CommandError(one.name() + " has no relay (pins: relay:)");
  if (!on && (job_on(one) || one.busy()))
    throw CommandError("the printer is at work: cancel the print first");
  if (on && pins->stop_pulled()) throw CommandError("the emergency stop is pulled: let it go first");
  if (on && !one.memory.held.empty()) throw CommandError(one.memory.held + ": `voidpath bed-clear` first");
  try {
    if (!pins->power_by_hand(on)) throw CommandError("the power was cut: `voidpath bed-clear` first");
  } catch (const fw::PinError& error) {
    throw CommandError(error.what());
  }
  s_.log.info("power", {{"printer", one.name()}, {"on", on ? "yes" : "no"}});
  changed();
}

void Runner::light(const std::string& name, bool on) {
  Printer& one = printer(name);
  if (one.pins() == nullptr || !one.pins()->has_light())
    throw CommandError(one.name() + " has no light (pins: light:)");
  try {
    one.pins()->light_by_hand(on);
  } catch (const fw::PinError& error) {
    throw CommandError(error.what());
  }
  changed();
}

}  // namespace voidpath::daemon

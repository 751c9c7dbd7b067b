#include "config/pins.h"

#include <utility>
#include <vector>

namespace voidpath::config {
namespace {

constexpr Range kDebounce_ms{0, 10000};
/// The emergency stop must act within a blink, whatever is configured.
constexpr Range kStopDebounce_ms{0, 50};

/// A normally closed contact to ground: pulled up, open is active.
constexpr PinBias kContactBias = PinBias::pull_up;

struct Use {
  std::string name;
  const PinConfig* pin;
};

std::vector<Use> uses_of(const PinsConfig& pins) {
  std::vector<Use> out;
  const auto add = [&](const char* name, const std::optional<PinConfig>& pin) {
    if (pin) out.push_back({name, &*pin});
  };
  add("emergency_stop", pins.emergency_stop);
  add("bed_button", pins.bed_button);
  add("door", pins.door);
  add("filament", pins.filament);
  add("relay", pins.relay);
  add("led", pins.led);
  add("light", pins.light);
  return out;
}

}  // namespace

void read_pins(Reader& r, PinsConfig& pins) {
  std::string chip;
  r.text("chip", chip);
  const auto pin = [&](const char* key, std::optional<PinConfig>& out, PinConfig given, const auto& more) {
    given.chip = chip;
    r.section(key, [&](Reader& p) {
      p.text("chip", given.chip);
      p.text("line", given.line);
      p.flag("active_low", given.active_low);
      p.choice("bias", given.bias,
               {{"as-is", PinBias::as_is},
                {"disabled", PinBias::disabled},
                {"pull-up", PinBias::pull_up},
                {"pull-down", PinBias::pull_down}});
      if (given.line.empty())
        p.fail("line", "which line of the chip is it? Its name, such as GPIO17, or its number");
      more(p, given);
      out = given;
    });
  };
  const auto input = [&](const char* key, std::optional<PinConfig>& out, bool active_low, double debounce_ms,
                         Range range) {
    pin(key, out, {"", "", active_low, kContactBias, debounce_ms},
        [&](Reader& p, PinConfig& c) { p.number("debounce_ms", c.debounce_ms, range); });
  };
  const auto plain = [](Reader&, PinConfig&) {};
  input("emergency_stop", pins.emergency_stop, false, 0, kStopDebounce_ms);
  input("bed_button", pins.bed_button, true, 30, kDebounce_ms);
  input("door", pins.door, false, 50, kDebounce_ms);
  input("filament", pins.filament, false, 500, kDebounce_ms);
  pin("relay", pins.relay, {}, [&](Reader& p, PinConfig&) {
    p.number("power_up_s", pins.power_up_s, {0, 120});
    p.number("idle_off_s", pins.idle_off_s, {0, 1e6});
  });
  pin("led", pins.led, {}, plain);
  pin("light", pins.light, {}, [&](Reader& p, PinConfig&) { p.flag("while_printing", pins.light_printing); });
}

void check_pins(const DaemonConfig& config) {
  struct Taken {
    std::string printer;
    Use use;
  };
  std::vector<Taken> taken;
  for (const PrinterConfig& printer : config.printers)
    for (const Use& use : uses_of(printer.pins)) {
      for (const Taken& other : taken)
        if (other.use.pin->chip == use.pin->chip && other.use.pin->line == use.pin->line)
          throw ConfigError((config.file.empty() ? "" : config.file.string() + ": ") + "printers: line " +
                            use.pin->line + " is both pins." + other.use.name + " of " + other.printer +
                            " and pins." + use.name + " of " + printer.name);
      taken.push_back({printer.name, use});
    }
}

}  // namespace voidpath::config

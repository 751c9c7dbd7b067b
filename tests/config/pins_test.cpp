#include "tests/config/scratch.h"

#include <catch2/catch.hpp>

using namespace voidpath::config;
using voidpath::test::error_of;
using voidpath::test::Scratch;
namespace fs = std::filesystem;

namespace {

std::string printer(const std::string& name, const std::string& pins) {
  return "  - name: " + name + "\n    profile: generic-marlin\n    port: /dev/" + name +
         "\n    pins: " + pins + "\n";
}

PinsConfig pins_of(const std::string& pins) {
  const Scratch scratch;
  return load_daemon(scratch.write("v.yaml", "printers:\n" + printer("a", pins))).printers.at(0).pins;
}

std::string refusal(const std::string& printers) {
  const Scratch scratch;
  return error_of([&] { load_daemon(scratch.write("v.yaml", "printers:\n" + printers)); });
}

}  // namespace

TEST_CASE("without pins a printer has none") {
  const Scratch scratch;
  const auto config =
      load_daemon(scratch.write("v.yaml", "printers:\n  - {name: a, profile: generic-marlin, port: x}\n"));
  const PinsConfig& pins = config.printers[0].pins;
  for (const auto* pin : {&pins.emergency_stop, &pins.bed_button, &pins.door, &pins.filament, &pins.relay,
                          &pins.led, &pins.light})
    CHECK_FALSE(*pin);
}

TEST_CASE("a contact that opens is active unless said otherwise, and a cut wire with it") {
  const auto pins = pins_of(
      "{chip: c0, emergency_stop: {line: 1}, bed_button: {line: 2}, door: {line: 3}, filament: {line: 4}, "
      "relay: {line: 5}}");
  for (const auto* pin : {&pins.emergency_stop, &pins.door, &pins.filament}) {
    REQUIRE(*pin);
    CHECK((*pin)->chip == "c0");
    CHECK((*pin)->bias == PinBias::pull_up);
    CHECK_FALSE((*pin)->active_low);
  }
  CHECK(pins.emergency_stop->debounce_ms == 0);
  CHECK(pins.bed_button->active_low);
  CHECK(pins.bed_button->debounce_ms == 30);
  CHECK(pins.relay->bias == PinBias::as_is);
  CHECK(pins.idle_off_s == 0);
  CHECK_FALSE(pins.led);
}

TEST_CASE("everything about a pin can be said") {
  const auto pins = pins_of(
      "{chip: c0, door: {chip: c1, line: GPIO22, active_low: true, bias: pull-down, debounce_ms: 7}, "
      "relay: {line: PSU, bias: disabled, power_up_s: 9, idle_off_s: 600}, light: {line: 8, while_printing: "
      "no}}");
  CHECK(pins.door->chip == "c1");
  CHECK(pins.door->line == "GPIO22");
  CHECK(pins.door->active_low);
  CHECK(pins.door->bias == PinBias::pull_down);
  CHECK(pins.door->debounce_ms == 7);
  CHECK(pins.relay->chip == "c0");
  CHECK(pins.relay->bias == PinBias::disabled);
  CHECK(pins.power_up_s == 9);
  CHECK(pins.idle_off_s == 600);
  CHECK_FALSE(pins.light_printing);
}

TEST_CASE("a pin that means nothing is refused by file, line and nearest word") {
  CHECK_THAT(refusal(printer("a", "{doors: {line: 1}}")), Catch::Contains("v.yaml:5") &&
                                                              Catch::Contains("printers[0].pins.doors") &&
                                                              Catch::Contains("did you mean 'door'"));
  CHECK_THAT(refusal(printer("a", "{door: {lines: 1}}")), Catch::Contains("which line of the chip"));
  CHECK_THAT(refusal(printer("a", "{door: {line: 1, pull: up}}")), Catch::Contains("unknown key"));
  CHECK_THAT(refusal(printer("a", "{door: {line: 1, bias: up}}")), Catch::Contains("pull-up"));
  CHECK_THAT(refusal(printer("a", "{led: {line: 1, debounce_ms: 3}}")), Catch::Contains("debounce_ms"));
  CHECK_THAT(refusal(printer("a", "{emergency_stop: {line: 1, debounce_ms: 51}}")),
             Catch::Contains("out of range, 0 to 50"));
}

TEST_CASE("no pin has two uses") {
  CHECK_THAT(refusal(printer("a", "{chip: c0, door: {line: 1}, led: {line: 1}}")),
             Catch::Contains("line 1 is both pins.door of a and pins.led of a"));
  CHECK_THAT(
      refusal(printer("a", "{chip: c0, door: {line: 1}}") + printer("b", "{chip: c0, relay: {line: 1}}")),
      Catch::Contains("pins.door of a and pins.relay of b"));
  CHECK(refusal(printer("a", "{chip: c0, door: {line: 1}}") + printer("b", "{chip: c1, door: {line: 1}}"))
            .empty());
}

TEST_CASE("the example in the shipped configuration is valid") {
  std::ifstream file(fs::path(VOIDPATH_SOURCE_DIR) / "config/voidpath.yaml");
  const std::string kHidden = "    # ";
  std::string text;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    inside = inside || line == kHidden + "pins:";
    const bool shown = inside && line.starts_with(kHidden);
    text += (shown ? "    " + line.substr(kHidden.size()) : line) + "\n";
  }
  const Scratch scratch;
  const auto pins = load_daemon(scratch.write("v.yaml", text)).printers.at(0).pins;
  CHECK(pins.emergency_stop->chip == "pinctrl-bcm2711");
  CHECK(pins.light);
  CHECK(pins.idle_off_s == 600);
}

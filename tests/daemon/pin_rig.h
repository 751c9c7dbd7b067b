#pragma once

#include "tests/daemon/fakes.h"

#include <string>
#include <utility>

#include <catch2/catch.hpp>

namespace voidpath::test {

inline config::PinConfig pin(const std::string& line, double debounce_ms = 0) {
  config::PinConfig out;
  out.line = line;
  out.debounce_ms = debounce_ms;
  return out;
}

inline config::PinsConfig every_pin() {
  config::PinsConfig out;
  out.emergency_stop = pin("stop");
  out.bed_button = pin("button", 30);
  out.door = pin("door", 50);
  out.filament = pin("filament", 500);
  out.relay = pin("relay");
  out.led = pin("led");
  out.light = pin("light");
  out.power_up_s = 3;
  out.idle_off_s = 600;
  return out;
}

/// A runner whose printer has pins of straw.
struct PinRig : RunnerRig {
  explicit PinRig(config::PinsConfig wired = every_pin(), bool auto_clear = false)
      : RunnerRig(auto_clear, std::move(wired)) {}

  void set(const std::string& line, bool active) {
    pins.set(line, active, loop.now_s());
    loop.run();
  }
  /// Pressed and let go, with all the bouncing a contact has.
  void press() {
    for (const bool level : {true, false, true}) set("button", level);
    loop.advance(0.1);
    set("button", false);
    loop.advance(0.1);
  }
  void print(const std::string& name) {
    drop(name);
    REQUIRE(reaches(name, daemon::State::waiting_bed));
    runner->bed_clear("");
    loop.run();
    loop.advance(3.1);
    REQUIRE(reaches(name, daemon::State::heating));
    begin_motion();
  }
  std::string waits() { return runner->waiting_reason(*runner->printers()[0]); }
  std::string shown(const std::string& name) {
    for (const auto& [pin_name, state] : runner->printers()[0]->pins()->words())
      if (pin_name == name) return state;
    return "";
  }
  bool pulled() {
    pins.set("stop", true);
    return loop.run_until([&] { return !runner->printers()[0]->memory.held.empty(); });
  }
  bool let_go() {
    pins.set("stop", false);
    return loop.run_until([&] { return shown("emergency stop") == "free"; });
  }
};

}  // namespace voidpath::test

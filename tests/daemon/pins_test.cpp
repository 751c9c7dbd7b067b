#include "daemon/pins/printer_pins.h"
#include "daemon/web/snapshot.h"
#include "tests/daemon/full_disk.h"
#include "tests/daemon/pin_rig.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath::test;
using namespace voidpath::daemon;
namespace fw = voidpath::fw;
namespace config = voidpath::config;

TEST_CASE("the bed button is the bed-clear command, and nothing moves before it") {
  PinRig rig;
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK(rig.printer.calls.empty());
  rig.set("button", true);
  rig.set("button", false);  // a spike
  rig.loop.advance(5);
  CHECK(rig.state_of("a.stl") == State::waiting_bed);
  CHECK_FALSE(rig.pins.active("relay"));
  rig.press();
  CHECK(rig.pins.active("relay"));
  CHECK(rig.printer.count("print") == 0);  // the power comes on first
  CHECK(rig.waits() == "the printer's power comes on");
  rig.loop.advance(3.1);
  CHECK(rig.state_of("a.stl") == State::heating);
  CHECK(rig.printer.count("print") == 1);
}

TEST_CASE("a button that is stuck at the start confirms nothing, and none does while it prints") {
  PinRig rig;
  rig.pins.set("button", true);
  rig.restart();
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  rig.loop.advance(5);
  CHECK(rig.state_of("a.stl") == State::waiting_bed);
  rig.set("button", false);
  rig.loop.advance(1);
  rig.press();
  rig.loop.advance(3.1);
  REQUIRE(rig.reaches("a.stl", State::heating));
  rig.begin_motion();
  rig.press();
  CHECK_FALSE(rig.runner->printers()[0]->memory.bed_clear);
}

TEST_CASE("M112 typed at the terminal stops as the button does, connected or not") {
  const std::string line = GENERATE("M112", " m112 ; now", "M117 stop\nM112");
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  if (line != "M112") rig.printer.say(fw::Disconnected{"unplugged"});
  rig.loop.run();
  rig.runner->command_line("", line);
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK(rig.printer.count("halt") >= 1);
  CHECK(rig.printer.count("command " + line) == 0);
  CHECK_FALSE(rig.runner->printers()[0]->memory.bed_clear);
  CHECK(rig.runner->printers()[0]->memory.held == "emergency stop by command");
}

TEST_CASE("a printer without power at an emergency stop is not stopped again when it has some") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  REQUIRE(rig.pulled());
  rig.printer.say(fw::Disconnected{"unplugged"});
  REQUIRE(rig.let_go());
  CHECK(rig.printer.count("forget_halt") == 1);  // the one before the print
  rig.runner->bed_clear("");
  CHECK(rig.printer.count("forget_halt") == 2);
}

TEST_CASE("the emergency stop cuts the power, halts, fails the job and holds the queue") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.drop("b.stl");
  REQUIRE(rig.pins.active("relay"));
  REQUIRE(rig.pulled());
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK(rig.printer.count("halt") >= 1);
  CHECK(rig.store->history().at(0).state == "failed");
  CHECK(rig.store->history().at(0).reason == "the emergency stop was pulled");
  CHECK(rig.shown("emergency stop") == "pulled");
  CHECK(rig.shown("power") == "cut off");
  rig.printer.say(fw::PrintFailed{"emergency stop"});
  rig.loop.run();
  rig.connect();
  CHECK(rig.waits().find("let it go") != std::string::npos);
  // Nothing helps while it is pulled.
  CHECK_THROWS_WITH(rig.runner->bed_clear(""), Catch::Contains("emergency stop is pulled"));
  CHECK_THROWS_WITH(rig.runner->power("", true), Catch::Contains("emergency stop is pulled"));
  rig.press();
  CHECK_FALSE(rig.pins.active("relay"));
  // Let go, it still waits for the user.
  REQUIRE(rig.let_go());
  CHECK_THROWS_WITH(rig.runner->power("", true), Catch::Contains("bed-clear"));
  rig.loop.advance(100);
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK(rig.state_of("b.stl") == State::waiting_bed);
  rig.runner->bed_clear("");
  rig.loop.run();
  CHECK(rig.pins.active("relay"));
  rig.loop.advance(3.1);
  CHECK(rig.state_of("b.stl") == State::heating);
}

TEST_CASE("a stop by command cuts the power too, before the printer hears of it") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.runner->printers()[0]->halt_now("emergency stop");  // any thread, past the loop
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK(rig.printer.count("halt") == 1);
  rig.runner->halted("", "emergency stop");
  CHECK(rig.shown("power") == "cut off");
}

TEST_CASE("a bed-clear that crossed an emergency stop on its way leaves no power on") {
  PinRig rig;
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  rig.runner->printers()[0]->halt_now("emergency stop");
  rig.runner->bed_clear("");
  rig.loop.run();
  rig.runner->halted("", "emergency stop");
  rig.loop.run();
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK(rig.shown("power") == "cut off");
  rig.loop.advance(10);
  CHECK(rig.state_of("a.stl") == State::waiting_bed);
  rig.runner->bed_clear("");
  rig.loop.run();
  CHECK(rig.pins.active("relay"));
}

TEST_CASE("an emergency stop that is pulled when the daemon starts lets nothing begin") {
  PinRig rig;
  rig.pins.set("stop", true);
  rig.restart();
  REQUIRE(rig.loop.run_until([&] { return !rig.runner->printers()[0]->memory.held.empty(); }));
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  CHECK_THROWS_AS(rig.runner->bed_clear(""), CommandError);
  CHECK_FALSE(rig.pins.active("relay"));
}

TEST_CASE("the relay is off until a print is to begin, and after idling") {
  PinRig rig;
  CHECK(rig.pins.driven("relay") == std::vector<bool>{false});
  rig.connect();
  rig.print("a.stl");
  CHECK(rig.pins.active("relay"));
  rig.finish(60);
  rig.loop.advance(599);
  CHECK(rig.pins.active("relay"));
  rig.loop.advance(2);
  CHECK_FALSE(rig.pins.active("relay"));
  rig.runner->power("", true);  // by hand, and again idle
  CHECK(rig.shown("power") == "on");
  rig.loop.advance(599);
  CHECK(rig.pins.active("relay"));
  rig.loop.advance(2);
  CHECK_FALSE(rig.pins.active("relay"));
}

TEST_CASE("a board that lives on the relay is powered for the print and only then spoken to") {
  PinRig rig;
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  rig.runner->bed_clear("");
  rig.loop.run();
  CHECK(rig.pins.active("relay"));
  rig.loop.advance(3.1);
  CHECK(rig.state_of("a.stl") == State::waiting_bed);
  rig.connect();
  CHECK(rig.state_of("a.stl") == State::heating);
}

TEST_CASE("any fault switches the power off until the bed is clear") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  SECTION("the print fails") { rig.printer.say(fw::PrintFailed{"thermal runaway"}); }
  SECTION("the cable is pulled") { rig.printer.say(fw::Disconnected{"gone"}); }
  rig.loop.run();
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK(rig.shown("lamp") == "fault");
  rig.connect();
  rig.drop("b.stl");
  REQUIRE(rig.reaches("b.stl", State::waiting_bed));
  rig.loop.advance(10);
  CHECK_FALSE(rig.pins.active("relay"));
  rig.press();
  CHECK(rig.pins.active("relay"));
}

TEST_CASE("after a fault the power stays off, whether or not the disk takes the fault down") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  REQUIRE(rig.pins.active("relay"));
  {
    const FullDisk full(rig);
    SECTION("the print fails") { rig.printer.say(fw::PrintFailed{"thermal runaway"}); }
    SECTION("the cable is pulled") { rig.printer.say(fw::Disconnected{"gone"}); }
    rig.loop.run();
    CHECK(rig.state_of("a.stl") == State::printing);  // as far as the disk knows
    CHECK_FALSE(rig.pins.active("relay"));
    rig.connect();
    rig.loop.advance(6);
    CHECK_FALSE(rig.pins.active("relay"));
    CHECK(rig.shown("lamp") == "fault");
    rig.runner->power("", true);  // by hand it is idle, whatever the disk says
    rig.loop.advance(601);
    CHECK_FALSE(rig.pins.active("relay"));
  }
  rig.loop.advance(6);
  REQUIRE_FALSE(rig.state_of("a.stl"));
  CHECK_FALSE(rig.pins.active("relay"));
  rig.print("b.stl");
  CHECK(rig.pins.active("relay"));
}

TEST_CASE("a lost connection while idle switches the power off, a restart at power-up does not") {
  PinRig rig;
  rig.connect();
  rig.runner->power("", true);
  rig.printer.say(fw::Disconnected{"the board starts anew"});
  rig.loop.run();
  CHECK(rig.pins.active("relay"));
  rig.connect();
  rig.loop.advance(3.1);
  rig.printer.say(fw::Disconnected{"gone"});
  rig.loop.run();
  CHECK_FALSE(rig.pins.active("relay"));
}

TEST_CASE("the power goes off with the daemon, in good order or not") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.runner.reset();
  CHECK_FALSE(rig.pins.active("relay"));
  CHECK_FALSE(rig.pins.active("light"));
  CHECK_FALSE(rig.pins.taken("relay"));
  CHECK_FALSE(rig.pins.taken("stop"));
}

TEST_CASE("a relay that cannot be switched lets nothing begin, and is tried again at the user's word") {
  PinRig rig;
  rig.connect();
  rig.drop("a.stl");
  REQUIRE(rig.reaches("a.stl", State::waiting_bed));
  rig.pins.fail("relay", "the expander does not answer");
  rig.runner->bed_clear("");
  rig.loop.advance(10);
  CHECK(rig.printer.count("print") == 0);
  CHECK(rig.waits() == "the power cannot be switched on: the expander does not answer");
  rig.pins.fail("relay", "");
  rig.runner->bed_clear("");
  rig.loop.run();
  rig.loop.advance(3.1);
  CHECK(rig.state_of("a.stl") == State::heating);
}

TEST_CASE("the lamp tells what the printer is at") {
  PinRig rig;
  rig.connect();
  CHECK(rig.shown("lamp") == "waiting for a clear bed");
  rig.runner->bed_clear("");
  rig.loop.run();
  CHECK(rig.shown("lamp") == "idle");
  rig.print("a.stl");
  CHECK(rig.shown("lamp") == "working");
  CHECK(rig.pins.active("led"));
  rig.printer.say(fw::Paused{true, "M0"});
  rig.loop.run();
  CHECK(rig.shown("lamp") == "paused");
  REQUIRE(rig.pulled());
  rig.loop.run();
  CHECK(rig.shown("lamp") == "fault");
  const auto before = rig.pins.driven("led").size();
  for (int i = 0; i < 10; ++i) rig.loop.advance(0.1);
  CHECK(rig.pins.driven("led").size() >= before + 9);
}

TEST_CASE("each state has a pattern of its own, and time decides what is lit") {
  CHECK(led_at(LedState::working, 1e6).lit);
  CHECK_FALSE(led_at(LedState::off, 0).lit);
  CHECK(std::isinf(led_at(LedState::working, 3).for_s));
  for (const auto state : {LedState::idle, LedState::waiting_bed, LedState::paused, LedState::fault}) {
    double lit_s = 0, t = 0;
    int changes = 0;
    for (bool last = false; t < 60;) {
      const Lit now = led_at(state, t);
      REQUIRE(now.for_s > 0);
      lit_s += now.lit ? now.for_s : 0;
      changes += now.lit != last;
      last = now.lit;
      t += now.for_s + 1e-9;
    }
    INFO(name_of(state));
    const double share = state == LedState::idle ? 1.0 / 30 : state == LedState::paused ? 0.1 : 0.5;
    CHECK(lit_s / t == Approx(share).epsilon(0.05));
    const int per_minute = state == LedState::idle          ? 40
                           : state == LedState::paused      ? 120
                           : state == LedState::waiting_bed ? 120
                                                            : 600;
    CHECK(std::abs(changes - per_minute) <= 4);
  }
}

TEST_CASE("the light goes with the print, or by hand; a lamp that fails ends no print") {
  PinRig rig;
  rig.connect();
  CHECK_FALSE(rig.pins.active("light"));
  rig.runner->light("", true);
  CHECK(rig.pins.active("light"));
  rig.runner->light("", false);
  rig.print("a.stl");
  CHECK(rig.pins.active("light"));
  rig.pins.fail("light", "broken");
  rig.finish(50);
  CHECK(rig.store->history().at(0).state == "done");
  CHECK_THROWS_WITH(rig.runner->light("", true), Catch::Contains("no light"));
}

TEST_CASE("without pins their commands say so, and a missing one keeps the daemon from starting") {
  RunnerRig bare;
  CHECK_THROWS_WITH(bare.runner->power("", true), Catch::Contains("no relay"));
  CHECK_THROWS_WITH(bare.runner->light("", true), Catch::Contains("no light"));
  CHECK(make_snapshot(*bare.runner, *bare.settler).status["printers"].items()[0]["pins"].is_null());
  PinRig rig;
  rig.pins.fail("stop", "there is no such chip");
  CHECK_THROWS_WITH(rig.restart(), "printer left, pins.emergency_stop: there is no such chip");
}

TEST_CASE("the status tells every pin in plain words") {
  PinRig rig;
  const auto status = make_snapshot(*rig.runner, *rig.settler).status;
  const auto& pins = status["printers"].items()[0]["pins"];
  CHECK(pins["emergency stop"].text() == "free");
  CHECK(pins["door"].text() == "closed");
  CHECK(pins["filament"].text() == "there");
  CHECK(pins["bed button"].text() == "not pressed");
  CHECK(pins["power"].text() == "off");
  CHECK(pins["light"].text() == "off");
}

TEST_CASE("all outputs can be switched off without a daemon") {
  FakePins pins;
  config::DaemonConfig config;
  config.printers.resize(2);
  config.printers[0].name = "a";
  config.printers[0].pins.relay = pin("r1");
  config.printers[1].name = "b";
  config.printers[1].pins.relay = pin("r2");
  config.printers[1].pins.light = pin("l2");
  for (const char* line : {"r1", "r2", "l2"}) pins.set(line, true);
  pins.fail("r1", "busy");
  CHECK_THROWS_WITH(switch_pins_off(config, pins), "printer a, pins.relay: busy");
  CHECK_FALSE(pins.active("r2"));
  CHECK_FALSE(pins.active("l2"));
}

#include "tests/daemon/full_disk.h"
#include "tests/daemon/pin_rig.h"

using namespace voidpath::test;
using namespace voidpath::daemon;
namespace fw = voidpath::fw;

/// Door and filament: what pauses a print, and what may set it going again.

TEST_CASE("an open door pauses with its reason; only a user goes on, and only behind a closed one") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.set("door", true);
  rig.loop.advance(0.06);
  CHECK(rig.printer.count("pause") >= 1);
  rig.printer.say(fw::Paused{});
  rig.loop.run();
  CHECK(rig.state_of("a.stl") == State::paused);
  CHECK(rig.runner->queue().at(0)->message == "the door was opened");
  CHECK(rig.shown("door") == "open");
  CHECK_THROWS_WITH(rig.runner->resume(""), Catch::Contains("the door is open"));
  rig.set("door", false);
  rig.loop.advance(0.06);
  CHECK(rig.state_of("a.stl") == State::paused);
  rig.runner->resume("");
  CHECK(rig.printer.count("resume") == 1);
  CHECK(rig.pins.active("relay"));  // heaters stayed on all the while
}

TEST_CASE("filament that runs out pauses; no print begins without filament or behind an open door") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.set("filament", true);
  rig.loop.advance(0.4);
  CHECK(rig.printer.count("pause") == 0);  // not yet quiet
  rig.loop.advance(0.2);
  CHECK(rig.printer.count("pause") >= 1);
  rig.printer.say(fw::Paused{});
  rig.loop.run();
  CHECK(rig.runner->queue().at(0)->message == "the filament ran out");
  rig.set("filament", false);
  rig.loop.advance(1);
  rig.runner->resume("");
  rig.printer.say(fw::Resumed{});
  rig.loop.run();
  rig.finish(60);
  rig.set("filament", true);
  rig.set("door", true);
  rig.loop.advance(1);
  rig.drop("b.stl");
  REQUIRE(rig.reaches("b.stl", State::waiting_bed));
  rig.runner->bed_clear("");
  rig.loop.advance(10);
  CHECK(rig.waits() == "the door is open");
  rig.set("door", false);
  rig.loop.advance(1);
  CHECK(rig.waits() == "there is no filament");
  CHECK(rig.printer.count("print") == 1);
  rig.set("filament", false);
  rig.loop.advance(1);
  rig.loop.advance(3.1);
  CHECK(rig.state_of("b.stl") == State::heating);
}

TEST_CASE("a guard whose pin fails counts as open") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.pins.fail("door", "the chip is gone");
  rig.loop.run();
  CHECK(rig.printer.count("pause") >= 1);
  CHECK(rig.shown("door") == "failed: the chip is gone");
  rig.printer.say(fw::Paused{});
  rig.loop.run();
  CHECK_THROWS_WITH(rig.runner->resume(""), Catch::Contains("the chip is gone"));
}

TEST_CASE("a print that the printer itself sets going behind an open door pauses again, each time") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  SECTION("paused by the door") {
    rig.set("door", true);
    rig.loop.advance(0.06);
    REQUIRE(rig.printer.count("pause") == 1);
    rig.printer.say(fw::Paused{});
  }
  SECTION("paused by itself, and opened to change the filament") {
    rig.printer.say(fw::Paused{true, "M600"});
    rig.set("door", true);
    rig.loop.advance(0.06);
  }
  SECTION("opened as the user's word to go on was under way") {
    rig.runner->pause("");
    rig.printer.say(fw::Paused{});
    rig.loop.run();
    rig.runner->resume("");
    rig.set("door", true);
    rig.loop.advance(0.06);
  }
  rig.loop.run();
  CHECK(rig.state_of("a.stl") == State::paused);
  for (int i = 0; i < 3; ++i) {
    const auto before = rig.printer.count("pause");
    rig.printer.say(fw::Resumed{});
    rig.loop.run();
    CHECK(rig.printer.count("pause") == before + 1);
    rig.printer.say(fw::Paused{});
    rig.loop.run();
    CHECK(rig.state_of("a.stl") == State::paused);
    CHECK(rig.runner->queue().at(0)->message == "the door is open");
  }
  rig.set("door", false);
  rig.loop.advance(0.06);
  const auto before = rig.printer.count("pause");
  rig.printer.say(fw::Resumed{});
  rig.loop.run();
  CHECK(rig.printer.count("pause") == before);
  CHECK(rig.state_of("a.stl") == State::printing);
}

TEST_CASE("an open door pauses what prints, whether or not the disk takes down what it was at") {
  PinRig rig;
  rig.connect();
  rig.print("a.stl");
  rig.printer.say(fw::Paused{true, "M600"});
  rig.loop.run();
  const FullDisk full(rig);
  rig.printer.say(fw::Resumed{});
  rig.loop.run();
  rig.set("door", true);
  rig.loop.advance(0.06);
  CHECK(rig.printer.count("pause") == 1);
  rig.loop.advance(6);
  CHECK(rig.printer.count("pause") == 1);
}

#include "firmware-io/gpio/debounce.h"
#include "firmware-io/gpio/emergency_stop.h"
#include "firmware-io/gpio/relay.h"
#include "tests/support/fake_pins.h"

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <thread>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using voidpath::test::FakePins;

namespace {

// No test waits for this long unless it fails.
constexpr auto kPatience = std::chrono::seconds(20);
constexpr double kNever = std::numeric_limits<double>::infinity();

PinOptions pin(const std::string& line) { return {"", line, false, Bias::as_is}; }

/// What the switch's thread did, in order.
class Deeds {
 public:
  void add(std::string what) {
    const std::lock_guard lock(mutex_);
    list_.push_back(std::move(what));
    changed_.notify_all();
  }
  bool wait_for(std::size_t count) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return list_.size() >= count; });
  }
  std::vector<std::string> list() {
    const std::lock_guard lock(mutex_);
    return list_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::string> list_;
};

EmergencyStopActions record(Deeds& deeds) {
  return {[&] { deeds.add("cut"); }, [&] { deeds.add("halt"); },
          [&](bool stopped, const std::string& why) { deeds.add((stopped ? "stopped: " : "free: ") + why); }};
}

}  // namespace

TEST_CASE("a contact counts once it has been quiet") {
  Debounce contact(0.03, false);
  CHECK(contact.deadline() == kNever);
  contact.edge(true, 1.000);  // bounces
  contact.edge(false, 1.004);
  contact.edge(true, 1.010);
  CHECK(contact.deadline() == Approx(1.040));
  CHECK_FALSE(contact.settle(1.039));
  CHECK_FALSE(contact.settled());
  REQUIRE(contact.settle(1.041));
  CHECK(contact.settled());
  CHECK_FALSE(contact.settle(2));  // told once
  CHECK(contact.deadline() == kNever);
  contact.edge(false, 3);
  CHECK(contact.settle(3.1) == std::optional(false));
}

TEST_CASE("a spike shorter than the quiet time never counts") {
  Debounce contact(0.03, false);
  for (int i = 0; i < 100; ++i) {
    const double t = 1 + i;
    contact.edge(true, t);
    contact.edge(false, t + 0.02);
    CHECK_FALSE(contact.settle(t + 0.5));
  }
}

TEST_CASE("an edge whose counterpart was lost starts the wait anew") {
  Debounce contact(0.03, false);
  contact.edge(true, 1.00);
  contact.edge(true, 1.02);  // it must have been inactive in between
  CHECK_FALSE(contact.settle(1.04));
  CHECK(contact.settle(1.05) == std::optional(true));
}

TEST_CASE("whatever the bouncing, the settled level is the last one that lasted") {
  std::uint32_t seed = 7;
  const auto next = [&] { return seed = seed * 1664525u + 1013904223u, seed >> 8; };
  for (int round = 0; round < 500; ++round) {
    Debounce contact(0.02, false);
    double t = 0;
    bool raw = false;
    bool expected = false;
    for (int i = 0; i < 40; ++i) {
      double stays = (next() % 400) * 1e-4;
      if (std::abs(stays - 0.02) < 1e-3) stays = 0.03;  // not within rounding of the limit itself
      raw = !raw;
      contact.edge(raw, t);
      t += stays;
      contact.settle(t);
      if (stays > 0.02) expected = raw;
      REQUIRE(contact.settled() == expected);
    }
  }
}

TEST_CASE("a relay is off before it is told to be on, and when it goes") {
  FakePins pins;
  {
    Relay relay(pins.output(pin("psu"), "test", false));
    CHECK_FALSE(relay.is_on());
    CHECK(relay.on());
    CHECK(relay.is_on());
    CHECK(pins.active("psu"));
  }
  CHECK_FALSE(pins.active("psu"));
  CHECK(pins.driven("psu") == std::vector<bool>{false, true, false});
}

TEST_CASE("a cut relay stays off until just that cut is forgiven") {
  FakePins pins;
  Relay relay(pins.output(pin("psu"), "test", false));
  relay.on();
  CHECK(relay.cut());
  CHECK_FALSE(pins.active("psu"));
  CHECK_FALSE(relay.on());
  CHECK_FALSE(pins.active("psu"));
  const auto seen = relay.cuts();
  relay.cut();  // pulled again while it was being let go
  relay.forgive(seen);
  CHECK_FALSE(relay.on());
  relay.forgive(relay.cuts());
  CHECK(relay.on());
}

TEST_CASE("a cut wins over switching on, whoever comes first") {
  for (int round = 0; round < 300; ++round) {
    FakePins pins;
    Relay relay(pins.output(pin("psu"), "test", false));
    std::thread cutter([&] { relay.cut(); });
    relay.on();
    cutter.join();
    REQUIRE_FALSE(pins.active("psu"));
    REQUIRE_FALSE(relay.is_on());
  }
}

TEST_CASE("a relay whose pin fails says so and is not on") {
  FakePins pins;
  Relay relay(pins.output(pin("psu"), "test", false));
  pins.fail("psu", "gone");
  CHECK_THROWS_AS(relay.on(), PinError);
  CHECK_FALSE(relay.is_on());
  CHECK_FALSE(relay.cut());
  CHECK(relay.is_cut());
}

TEST_CASE("a pulled switch cuts the power, then halts, then tells") {
  FakePins pins;
  Deeds deeds;
  EmergencyStop stop(pins.input(pin("stop"), "test"), {}, record(deeds));
  CHECK_FALSE(stop.pulled());
  pins.set("stop", true);
  REQUIRE(deeds.wait_for(3));
  CHECK(deeds.list() == std::vector<std::string>{"cut", "halt", "stopped: the emergency stop was pulled"});
  CHECK(stop.pulled());
  pins.set("stop", false);
  REQUIRE(deeds.wait_for(4));
  CHECK(deeds.list().back() == "free: the emergency stop was let go");
  CHECK_FALSE(stop.pulled());
  pins.set("stop", true);  // it works more than once
  REQUIRE(deeds.wait_for(7));
  CHECK(deeds.list()[4] == "cut");
}

TEST_CASE("a switch counts as pulled before the power is cut, so that nobody forgives that cut") {
  FakePins pins;
  Deeds deeds;
  const EmergencyStop* seen = nullptr;
  auto actions = record(deeds);
  actions.cut = [&] { deeds.add(seen->pulled() ? "cut, pulled" : "cut, free"); };
  EmergencyStop stop(pins.input(pin("stop"), "test"), {}, std::move(actions));
  seen = &stop;
  SECTION("pulled") { pins.set("stop", true); }
  SECTION("lost") { pins.fail("stop", "the chip is gone"); }
  REQUIRE(deeds.wait_for(3));
  CHECK(deeds.list()[0] == "cut, pulled");
}

TEST_CASE("however short, a pull is seen") {
  FakePins pins;
  Deeds deeds;
  EmergencyStop stop(pins.input(pin("stop"), "test"), {}, record(deeds));
  pins.set("stop", true, 1);
  pins.set("stop", false, 1.000001);
  REQUIRE(deeds.wait_for(4));
  CHECK(deeds.list()[0] == "cut");
  CHECK(deeds.list()[3] == "free: the emergency stop was let go");
}

TEST_CASE("with a quiet time asked for, a spike does not stop a print, and a pull does") {
  FakePins pins;
  Deeds deeds;
  // Hours: only the stamps decide, not how fast this test runs.
  EmergencyStop stop(pins.input(pin("stop"), "test"), {3600, 0.001}, record(deeds));
  pins.set("stop", true, 1);
  pins.set("stop", false, 2);
  pins.set("stop", true, -7200);  // long ago: it has lasted
  REQUIRE(deeds.wait_for(3));
  CHECK(deeds.list()[2] == "stopped: the emergency stop was pulled");
  CHECK(deeds.list().size() == 3);
}

TEST_CASE("a switch that is pulled at the start stops at once") {
  FakePins pins;
  pins.set("stop", true);
  Deeds deeds;
  EmergencyStop stop(pins.input(pin("stop"), "test"), {}, record(deeds));
  CHECK(stop.pulled());
  REQUIRE(deeds.wait_for(3));
  CHECK(deeds.list() == std::vector<std::string>{"cut", "halt", "stopped: the emergency stop is pulled"});
}

TEST_CASE("a level whose edge was lost is found by looking") {
  FakePins pins;
  Deeds deeds;
  EmergencyStop stop(pins.input(pin("stop"), "test"), {0, 0.001}, record(deeds));
  pins.set_silently("stop", true);
  REQUIRE(deeds.wait_for(3));
  CHECK(deeds.list()[0] == "cut");
}

TEST_CASE("a switch whose pin fails counts as pulled for good") {
  FakePins pins;
  Deeds deeds;
  EmergencyStop stop(pins.input(pin("stop"), "test"), {}, record(deeds));
  pins.fail("stop", "the chip is gone");
  REQUIRE(deeds.wait_for(3));
  CHECK(deeds.list()[2] == "stopped: the emergency stop's pin failed: the chip is gone");
  CHECK(stop.pulled());
}

TEST_CASE("a computer without GPIO chips says what is missing") {
  const auto pins = kernel_pins();
  CHECK_THROWS_WITH(pins->input({"no-such-chip", "GPIO17", false, Bias::as_is}, "test"),
                    Catch::StartsWith("pin GPIO17 of no-such-chip: "));
  CHECK_THROWS_WITH(pins->output({"/dev/no-such-chip", "3", false, Bias::as_is}, "test", false),
                    Catch::Contains("line 3 of /dev/no-such-chip: No such file"));
}

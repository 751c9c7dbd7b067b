#include "firmware-io/clock.h"
#include "firmware-io/gpio/emergency_stop.h"
#include "firmware-io/gpio/relay.h"
#include "tests/gpio/sim_chip.h"

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <vector>

#include <catch2/catch.hpp>
#include <poll.h>
#include <sys/wait.h>

using namespace voidpath::fw;
using voidpath::test::SimChip;

namespace {

PinOptions line(const std::string& chip, const std::string& name, bool active_low = false,
                Bias bias = Bias::as_is) {
  return {chip, name, active_low, bias};
}

// The simulator raises its interrupts with the next tick of the clock, 10 ms at the latest.
std::optional<Edge> wait_for_edge(InputPin& pin) {
  pollfd waiting{pin.fd(), POLLIN, 0};
  if (::poll(&waiting, 1, 2000) != 1) return std::nullopt;
  return pin.next_edge();
}

}  // namespace

TEST_CASE("an input tells level and both edges, stamped by the clock everyone uses") {
  SimChip chip("board");
  const auto pin = kernel_pins()->input(line("board", "3"), "test");
  CHECK_FALSE(pin->active());
  CHECK_FALSE(pin->next_edge());
  const double before = steady_clock()->now_s();
  chip.pull(3, true);
  const auto up = wait_for_edge(*pin);
  REQUIRE(up);
  CHECK(up->active);
  CHECK(up->at_s >= before);
  CHECK(up->at_s <= steady_clock()->now_s());
  CHECK(pin->active());
  chip.pull(3, false);
  const auto down = wait_for_edge(*pin);
  REQUIRE(down);
  CHECK_FALSE(down->active);
  CHECK(down->at_s >= up->at_s);
  CHECK_FALSE(pin->next_edge());
}

TEST_CASE("several edges wait their turn") {
  SimChip chip("board");
  const auto pin = kernel_pins()->input(line("board", "0"), "test");
  // When the second line's edge has come, so has the first one's.
  const auto marker = kernel_pins()->input(line("board", "7"), "test");
  for (int i = 0; i < 10; ++i) {
    chip.pull(0, i % 2 == 0);
    chip.pull(7, i % 2 == 0);
    REQUIRE(wait_for_edge(*marker));
  }
  for (int i = 0; i < 10; ++i) {
    const auto edge = pin->next_edge();
    REQUIRE(edge);
    CHECK(edge->active == (i % 2 == 0));
  }
  CHECK_FALSE(pin->next_edge());
}

TEST_CASE("active low turns levels and edges round") {
  SimChip chip("board");
  const auto pin = kernel_pins()->input(line("board", "2", true), "test");
  CHECK(pin->active());
  chip.pull(2, true);
  const auto edge = wait_for_edge(*pin);
  REQUIRE(edge);
  CHECK_FALSE(edge->active);
  CHECK_FALSE(pin->active());
}

TEST_CASE("the chip's own resistor is used when asked for") {
  SimChip chip("board");
  const auto up = kernel_pins()->input(line("board", "1", false, Bias::pull_up), "test");
  CHECK(up->active());
  const auto down = kernel_pins()->input(line("board", "2", false, Bias::pull_down), "test");
  CHECK_FALSE(down->active());
}

TEST_CASE("an output drives its line from the first moment, and reads back") {
  SimChip chip("board");
  const auto pin = kernel_pins()->output(line("board", "5"), "test", true);
  CHECK(chip.level(5));
  CHECK(pin->active());
  pin->set(false);
  CHECK_FALSE(chip.level(5));
  CHECK_FALSE(pin->active());
  const auto inverse = kernel_pins()->output(line("board", "6", true), "test", false);
  CHECK(chip.level(6));
  inverse->set(true);
  CHECK_FALSE(chip.level(6));
  CHECK(inverse->active());
}

TEST_CASE("chips go by name, path and label, lines by number and name") {
  SimChip other("other", 4, {{0, "SHARED"}});
  SimChip chip("board", 8, {{0, "SHARED"}, {4, "GPIO17"}, {5, "7"}});
  const auto pins = kernel_pins();
  for (const std::string& name : {chip.name(), chip.path(), std::string("board"), std::string()}) {
    INFO(name);
    const auto pin = pins->output(line(name, "GPIO17"), "test", true);
    CHECK(chip.level(4));
    pin->set(false);
  }
  const auto named = pins->output(line("board", "7"), "test", true);  // a name before it is a number
  CHECK(chip.level(5));
  CHECK_THROWS_WITH(pins->input(line("", "SHARED"), "test"), Catch::Contains("more than one chip"));
  CHECK_THROWS_WITH(pins->input(line("", "3"), "test"), Catch::Contains("more than one chip is meant"));
}

TEST_CASE("what is wrong with a pin is said") {
  SimChip chip("board");
  const auto pins = kernel_pins();
  const auto first = pins->input(line("board", "1"), "test");
  CHECK_THROWS_WITH(pins->input(line("board", "1"), "test"), Catch::StartsWith("pin line 1 of board: ") &&
                                                                 Catch::Contains("busy") &&
                                                                 Catch::Contains("gpioinfo"));
  CHECK_THROWS_WITH(pins->output(line("bored", "1"), "test", false),
                    Catch::Contains("no such chip; there are " + chip.name() + " (board)"));
  CHECK_THROWS_WITH(pins->input(line("board", "GPIO17"), "test"), Catch::Contains("no line of this name"));
  CHECK_THROWS_WITH(pins->input(line("board", "8"), "test"), Catch::Contains("lines 0 to 7"));
  REQUIRE(::seteuid(65534) == 0);
  std::string refusal;
  try {
    pins->input(line("board", "2"), "test");
  } catch (const PinError& error) {
    refusal = error.what();
  }
  REQUIRE(::seteuid(0) == 0);
  CHECK_THAT(refusal, Catch::Contains("Permission denied") && Catch::Contains("group gpio"));
}

TEST_CASE("a line is given back and can be had again") {
  SimChip chip("board");
  for (int i = 0; i < 3; ++i) CHECK_NOTHROW(kernel_pins()->output(line("board", "1"), "test", true));
  CHECK_NOTHROW(kernel_pins()->input(line("board", "1"), "test"));
}

TEST_CASE("the emergency stop: edge, relay off, halt called, then told") {
  SimChip chip("board");
  chip.pull(1, false);
  const auto pins = kernel_pins();
  Relay relay(pins->output(line("board", "4"), "relay", false));
  REQUIRE(relay.on());
  REQUIRE(chip.level(4));
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> deeds;
  double halted_at = 0;
  bool on_at_halt = true;
  EmergencyStopActions actions;
  actions.cut = [&] { relay.cut(); };
  actions.halt = [&] {
    halted_at = steady_clock()->now_s();
    on_at_halt = chip.level(4);
  };
  actions.report = [&](bool stopped, const std::string& why) {
    const std::lock_guard lock(mutex);
    deeds.push_back((stopped ? "stopped: " : "free: ") + why);
    changed.notify_all();
  };
  const auto wait_for = [&](std::size_t count) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(10), [&] { return deeds.size() >= count; });
  };
  EmergencyStop stop(pins->input(line("board", "1"), "stop"), {}, std::move(actions));
  std::vector<double> delays_ms;
  for (std::size_t i = 0; i < 50; ++i) {
    const double pulled_at = steady_clock()->now_s();
    chip.pull(1, true);
    REQUIRE(wait_for(2 * i + 1));
    delays_ms.push_back((halted_at - pulled_at) * 1000);
    CHECK_FALSE(on_at_halt);
    CHECK_FALSE(chip.level(4));
    CHECK_FALSE(relay.on());
    chip.pull(1, false);
    REQUIRE(wait_for(2 * i + 2));
    relay.forgive(relay.cuts());
    REQUIRE(relay.on());
  }
  std::sort(delays_ms.begin(), delays_ms.end());
  WARN("pull to halt, the simulator's tick of up to 10 ms included: median " << delays_ms[25] << " ms, worst "
                                                                             << delays_ms.back() << " ms");
  CHECK(deeds[0] == "stopped: the emergency stop was pulled");
  CHECK(deeds[1] == "free: the emergency stop was let go");
}

TEST_CASE("a chip that vanishes under the emergency stop counts as pulled") {
  auto chip = std::make_unique<SimChip>("board");
  std::mutex mutex;
  std::condition_variable changed;
  std::string told;
  EmergencyStopActions actions;
  actions.cut = [] {};
  actions.halt = [] {};
  actions.report = [&](bool, const std::string& why) {
    const std::lock_guard lock(mutex);
    told = why;
    changed.notify_all();
  };
  EmergencyStop stop(kernel_pins()->input(line("board", "1"), "stop"), {0, 0.01}, std::move(actions));
  chip->unplug();
  std::unique_lock lock(mutex);
  REQUIRE(changed.wait_for(lock, std::chrono::seconds(10), [&] { return !told.empty(); }));
  CHECK_THAT(told, Catch::StartsWith("the emergency stop's pin failed: pin line 1 of board: "));
  CHECK(stop.pulled());
}

TEST_CASE("a relay's line is given back when its process is killed, and its wire goes where it is pulled") {
  SimChip chip("board");
  chip.pull(4, false);
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    Relay relay(kernel_pins()->output(line("board", "4"), "relay", false));
    relay.on();
    [[maybe_unused]] const auto written = ::write(ends[1], "x", 1);
    for (;;) ::pause();
  }
  char ready = 0;
  REQUIRE(::read(ends[0], &ready, 1) == 1);
  CHECK(chip.level(4));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  CHECK_FALSE(chip.level(4));
  CHECK_NOTHROW(kernel_pins()->output(line("board", "4"), "relay", false));
  ::close(ends[0]);
  ::close(ends[1]);
}

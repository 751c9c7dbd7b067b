#include "tests/firmware-io/session_rig.h"

#include <atomic>
#include <future>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using namespace voidpath::test;

namespace {

/// Closes the port whenever it is told to halt.
struct Halter final : Dialogue {
  struct Script {
    std::function<void()> opened = [] {}, shut_down = [] {};
    int unheard = 0;  ///< so many halts the printer does not hear
    bool printing = false, cold = false;
    int repeats = 0;  ///< so often a halt is said again before the printer hears it
    std::atomic<int> halts{0};
  };
  explicit Halter(Script& s) : script(s) {}
  void opened(double /*t*/) override {
    closed = heard = false;
    script.opened();
  }
  void halt(const std::string& /*reason*/, double /*t*/) override {
    closed = script.repeats == 0;
    heard = ++script.halts > script.unheard;
  }
  void shut_down(double /*t*/) override { script.shut_down(); }
  bool halt_heard() const noexcept override { return heard; }
  bool closing() const noexcept override { return closed; }
  bool finished() const noexcept override { return !script.printing; }
  bool cold() const noexcept override { return script.cold || finished(); }
  double deadline() const noexcept override { return script.halts > 0 ? 0 : 1e300; }
  std::string& output() noexcept override { return out; }
  bool take_urgent() noexcept override { return false; }
  void received(std::string_view /*bytes*/, double /*t*/) override {}
  void elapsed(double /*t*/) override {
    if (script.halts > 0 && !closed) closed = --script.repeats == 0;
  }
  void lost(const std::string& /*reason*/) override {}
  void print(std::unique_ptr<LineSource> /*source*/, double /*t*/) override {}
  void pause() override {}
  void resume(double /*t*/) override {}
  void cancel(const std::string& /*reason*/, double /*t*/) override {}
  void command(const std::string& /*text*/, double /*t*/) override {}

  Script& script;
  bool closed = false, heard = false;
  std::string out;
};

/// Behind it there are loopbacks without a printer.
std::unique_ptr<PrinterPort> halter_session(Halter::Script& script, std::vector<Loopback>& opened) {
  const auto open = [&opened] {
    opened.push_back(make_loopback());
    return std::move(opened.back().host);
  };
  const auto make = [&script](const Clock&, FlightRecorder&, const PrinterPort::Handler&) {
    return std::make_unique<Halter>(script);
  };
  return start_session(
      {.reconnect_s = 0.001, .shutdown_s = 0.02}, open, steady_clock(), [](const Event&) {}, make);
}

}  // namespace

TEST_CASE("halt reaches a firmware whose queue is full", "[session]") {
  SessionRig rig;
  REQUIRE(rig.listener.wait_for<Connected>());
  rig.port->print(source(moves(100000)));
  REQUIRE(rig.listener.wait_for<LineDone>(50));
  rig.port->halt("button");
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  REQUIRE(rig.listener.wait_for<Disconnected>());
  CHECK(rig.listener.last<PrintFailed>().reason == "button");
  CHECK(rig.listener.last<Disconnected>().reason == "button");
  CHECK(rig.peer().dies());
}

TEST_CASE("an emergency stop while the port is gone is the first that goes out when it is back",
          "[session]") {
  SessionRig rig;
  REQUIRE(rig.halt_unplugged());
  rig.plug();
  CHECK(rig.peer(2).dies());
  CHECK(rig.peer(2).executed().empty());
}

TEST_CASE("an emergency stop that a person has seen to is not said to the printer when its port is back",
          "[session]") {
  SessionRig rig;
  REQUIRE(rig.halt_unplugged());
  rig.port->forget_halt();
  rig.port->print(source(moves(1)));
  REQUIRE(rig.listener.wait_for<PrintFailed>());  // all before it has been carried out
  rig.plug();
  REQUIRE(rig.listener.wait_for<Connected>(2));
  CHECK(rig.peers.size() == 2);
}

TEST_CASE("an emergency stop that the cable took with it is said again", "[session]") {
  SessionRig rig;
  REQUIRE(rig.print_to_hold());
  rig.peer().fall_deaf();
  rig.port->halt("button");
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  rig.unplug();
  rig.plug();
  CHECK(rig.peer(2).dies());
}

TEST_CASE("an emergency stop that was heard is not said to the next printer", "[session]") {
  SessionRig rig;
  REQUIRE(rig.listener.wait_for<Connected>());
  rig.port->halt("button");
  REQUIRE(rig.peer().dies());
  REQUIRE(rig.listener.wait_for<Connected>(2));
}

TEST_CASE("an emergency stop that comes while its session ends still goes out", "[session]") {
  Halter::Script script;
  std::vector<Loopback> loopbacks;
  std::promise<void> opened;
  PrinterPort* stopped = nullptr;
  script.opened = [&] { opened.set_value(); };
  script.shut_down = [&] { stopped->halt("button"); };
  auto port = halter_session(script, loopbacks);
  stopped = port.get();
  REQUIRE(opened.get_future().wait_for(kPatience) == std::future_status::ready);
  port.reset();
  CHECK(script.halts == 1);
}

TEST_CASE("an emergency stop is said anew at each opening until the printer has heard it", "[session]") {
  Halter::Script script;
  script.unheard = 1;
  std::vector<Loopback> loopbacks;
  std::promise<void> opened, opened_again;
  int openings = 0;
  script.opened = [&] {
    if (++openings == 1) opened.set_value();
    if (openings == 3) opened_again.set_value();
  };
  auto port = halter_session(script, loopbacks);
  REQUIRE(opened.get_future().wait_for(kPatience) == std::future_status::ready);
  port->halt("button");
  REQUIRE(opened_again.get_future().wait_for(kPatience) == std::future_status::ready);
  port.reset();
  CHECK(script.halts == 2);
}

TEST_CASE("a print that does not end in time when its session does is stopped, unless it is cold",
          "[session]") {
  Halter::Script script;
  script.printing = true;
  SECTION("heard at once") {}
  SECTION("heard late") { script.repeats = 5; }
  SECTION("cold") { script.cold = true; }
  std::vector<Loopback> loopbacks;
  std::promise<void> opened;
  script.opened = [&] { opened.set_value(); };
  auto port = halter_session(script, loopbacks);
  REQUIRE(opened.get_future().wait_for(kPatience) == std::future_status::ready);
  port.reset();
  CHECK(script.halts == (script.cold ? 0 : 1));
  CHECK(script.repeats == 0);
}

#pragma once

#include "firmware-io/marlin/driver.h"
#include "tests/firmware-io/driver_bench.h"
#include "tests/mock_printer/mock_marlin.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::test {

/// A driver and the mock printer with its wire, in memory, on one invented clock that jumps to whatever comes
/// next. Time begins at 1000 s for the driver and at 0 for the printer.
class MockBench {
 public:
  explicit MockBench(const mock::Options& firmware, fw::marlin::DriverOptions options = {})
      : printer(firmware),
        driver(std::move(options), clock, recorder, [this](const fw::Event& e) { note(e); }) {
    printer.on_command([this](std::string_view command) { log.emplace_back(command); });
    clock.now = kStart;
    driver.opened(t());
  }

  double t() const { return clock.now; }

  /// Runs until the condition holds; false when that takes longer than so many invented seconds.
  bool run_until(const std::function<bool()>& done, double seconds = 60) {
    const double end = t() + seconds;
    while (!done()) {
      if (t() > end) return false;
      step();
    }
    return true;
  }
  void run_for(double seconds) {
    const double end = t() + seconds;
    while (t() < end) step();
  }
  bool connect() {
    return run_until([&] { return count<fw::Connected>() > 0 && driver.deadline() > t(); });
  }
  void print(std::vector<std::string> lines) {
    driver.print(std::make_unique<MemorySource>(std::move(lines)), t());
  }
  bool connected() const { return connected_; }
  bool over() const {
    return count<fw::PrintFinished>() + count<fw::PrintFailed>() + count<fw::PrintCancelled>() > 0;
  }

  template <typename T>
  int count() const {
    const auto found = counts_.find(decltype(fw::Event::what)(T{}).index());
    return found == counts_.end() ? 0 : found->second;
  }
  /// The n-th event of a kind, or nothing.
  template <typename T>
  const T* find(int n = 0) const {
    for (const fw::Event& event : events)
      if (const T* found = std::get_if<T>(&event.what); found && n-- == 0) return found;
    return nullptr;
  }

  FakeClock clock;
  fw::FlightRecorder recorder;
  mock::MockMarlin printer;
  fw::marlin::Driver driver;
  std::vector<fw::Event> events;
  std::vector<std::string> log;                        ///< what the printer executed, in order
  std::function<void(const std::string&)> on_output;   ///< what the driver writes
  std::function<std::string(std::string)> to_printer;  ///< damages it
  std::function<std::string(std::string)> to_host;     ///< damages what the printer said
  std::function<void(const std::string&)> on_input;    ///< what it reads
  double read_every_s = 0;                             ///< a host too busy to read more often
  bool rests = false;  ///< what comes is left lying as long as the driver says

 private:
  static constexpr double kStart = 1000;
  static constexpr double kReopen_s = 2;
  double unplugged_until_ = 0;
  bool connected_ = false;
  std::map<std::size_t, int> counts_;  ///< by kind
  static constexpr double kRounding_s = 1e-9;

  void plug() {
    unplugged_until_ = 0;
    printer.take_output();
    if (driver.closing()) driver.opened(t());
  }
  void note(const fw::Event& event) {
    if (std::holds_alternative<fw::Connected>(event.what)) connected_ = true;
    if (std::holds_alternative<fw::Disconnected>(event.what)) connected_ = false;
    ++counts_[event.what.index()];
    events.push_back(event);
  }

  void step() {
    if (!driver.output().empty()) {
      if (on_output) on_output(driver.output());
      const std::string said = std::exchange(driver.output(), {});
      printer.feed(to_printer ? to_printer(said) : said);
    }
    if (unplugged_until_ > 0 && t() >= unplugged_until_) plug();
    if (driver.closing() && unplugged_until_ == 0) unplugged_until_ = t() + kReopen_s;
    // On the printer's clock, so that its events are met exactly.
    double next = std::clamp(std::min(printer.next_event(), driver.deadline() - kStart), printer.now(),
                             printer.now() + 1);
    if (read_every_s > 0) next = std::max(next, printer.now() + read_every_s);
    const double rest_until = rests && !driver.closing() ? driver.unhurried_until() : 0;
    if (rest_until > t()) next = std::max(next, rest_until - kStart);
    printer.advance_to(next);
    clock.now = std::max(t(), next + kStart);
    if (rest_until > 0) driver.rested(rest_until, t());
    std::string said = printer.take_output();
    if (to_host && !said.empty()) said = to_host(std::move(said));
    if (const auto seconds = printer.take_unplug()) {
      driver.lost("unplugged");
      unplugged_until_ = t() + *seconds;
    }
    if (!said.empty() && on_input) on_input(said);
    if (!said.empty() && !driver.closing()) driver.received(said, t());
    if (t() + kRounding_s >= driver.deadline()) {
      clock.now = std::max(t(), driver.deadline());
      driver.elapsed(t());
    }
  }
};

}  // namespace voidpath::test

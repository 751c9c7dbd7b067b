#pragma once

#include "firmware-io/s3g/driver.h"
#include "tests/firmware-io/driver_bench.h"
#include "tests/mock_printer/mock_s3g.h"

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::test {

/// A driver and the mock of a MakerBot on one invented clock that jumps to whatever comes next.
class S3gBench {
 public:
  explicit S3gBench(const mock::S3gOptions& printer = {}, fw::s3g::DriverOptions options = {})
      : mock(printer),
        driver(on_wire(std::move(options), printer), clock, recorder, [this](const fw::Event& event) {
          ++counts_[event.what.index()];
          events.push_back(event);
        }) {
    mock.on_payload([this](const std::string& payload) { executed.push_back(payload); });
    driver.opened(0);
  }

  /// Runs until the condition holds; false when that takes longer than so many invented seconds.
  bool run_until(const std::function<bool()>& done, double seconds = 3600) {
    const double end = t + seconds;
    while (!done()) {
      if (t > end) return false;
      step();
    }
    return true;
  }
  void run_for(double seconds) {
    const double end = t + seconds;
    while (t < end) step();
  }
  bool connect() {
    return run_until([&] { return count<fw::Connected>() > 0; }, 30);
  }
  void print(std::vector<std::string> lines) {
    driver.print(std::make_unique<MemorySource>(std::move(lines)), t);
  }
  bool over() const {
    return count<fw::PrintFinished>() + count<fw::PrintFailed>() + count<fw::PrintCancelled>() > 0;
  }
  /// Until more than so many commands are done.
  bool print_into(std::vector<std::string> lines, std::size_t done) {
    print(std::move(lines));
    return run_until([&] { return executed.size() > done; });
  }
  bool print_through(std::vector<std::string> lines, double seconds = 7200) {
    print(std::move(lines));
    return run_until([&] { return over(); }, seconds);
  }

  void forget_events() { events.clear(), counts_.clear(); }

  template <typename T>
  int count() const {
    const auto found = counts_.find(decltype(fw::Event::what)(T{}).index());
    return found == counts_.end() ? 0 : found->second;
  }
  template <typename T>
  const fw::Event* first() const {
    for (const fw::Event& event : events) {
      if (std::holds_alternative<T>(event.what)) return &event;
    }
    return nullptr;
  }
  std::string failure() const {
    const fw::Event* event = first<fw::PrintFailed>();
    return event ? std::get<fw::PrintFailed>(event->what).reason : "";
  }
  bool said(const std::string& text) const {
    return std::any_of(events.begin(), events.end(), [&](const fw::Event& event) {
      const auto* message = std::get_if<fw::Message>(&event.what);
      return message && message->text.find(text) != std::string::npos;
    });
  }

  FakeClock clock;
  fw::FlightRecorder recorder;
  mock::MockS3g mock;
  fw::s3g::Driver driver;
  std::vector<fw::Event> events;
  std::vector<std::string> executed;  ///< payloads in the order in which they left the queue
  double t = 0;
  double longest_stall_s = 0;  ///< motors at rest for want of moves, while a print was being fed
  std::function<void()> each_step;
  std::function<void(const std::string&)> on_output;  ///< what the driver writes
  std::function<void(const std::string&)> on_input;   ///< what it reads

 private:
  static fw::s3g::DriverOptions on_wire(fw::s3g::DriverOptions options, const mock::S3gOptions& printer) {
    if (printer.baud > 0) options.timing.byte_s = 10 / printer.baud;
    return options;
  }

  std::map<std::size_t, int> counts_;  ///< by kind

  void step() {
    std::string& output = driver.output();
    if (!output.empty()) {
      if (on_output) on_output(output);
      mock.feed(std::exchange(output, {}));
    }
    std::string input = mock.take_output();
    if (!input.empty()) {
      if (on_input) on_input(input);
      driver.received(input, t);
    }
    if (t >= driver.deadline()) driver.elapsed(t);
    if (each_step) each_step();
    if (!driver.output().empty()) return;
    const double next = std::min({driver.deadline(), mock.next_event(), t + 1.0});
    t = clock.now = std::max(next, t + 1e-6);
    mock.advance_to(t);
  }
};

}  // namespace voidpath::test

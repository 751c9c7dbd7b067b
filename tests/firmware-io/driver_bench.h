#pragma once

#include "firmware-io/marlin/driver.h"
#include "tests/firmware-io/model_firmware.h"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace voidpath::test {

class FakeClock final : public fw::Clock {
 public:
  double now_s() const noexcept override { return now; }
  double now = 0;
};

/// Lines from memory, numbered from 0.
class MemorySource final : public fw::LineSource {
 public:
  explicit MemorySource(std::vector<std::string> lines) : lines_(std::move(lines)) {}
  std::optional<fw::SourceLine> next() override {
    if (at_ == fail_at) throw std::runtime_error("the file went away");
    if (at_ == lines_.size()) return {};
    const auto index = static_cast<std::uint32_t>(at_);
    return fw::SourceLine{lines_[at_++], index};
  }
  std::uint64_t position() const noexcept override { return at_ * 10; }
  std::uint64_t size() const noexcept override { return lines_.size() * 10; }
  std::size_t fail_at = static_cast<std::size_t>(-1);

 private:
  std::vector<std::string> lines_;
  std::size_t at_ = 0;
};

/// A driver and the model firmware on a wire, all on one invented clock that jumps to whatever comes next.
class DriverBench {
 public:
  explicit DriverBench(ModelOptions model = {}, fw::marlin::DriverOptions options = {})
      : firmware(model), driver(options, clock, recorder, [this](const fw::Event& event) { note(event); }) {
    t = clock.now = 1000;
    driver.opened(t);
  }

  /// Runs until the condition holds; false when that takes longer than so many invented seconds.
  bool run_until(const std::function<bool()>& done, double seconds = 60) {
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

  void print(std::vector<std::string> lines) {
    driver.print(std::make_unique<MemorySource>(std::move(lines)), t);
  }
  bool connect() {
    return run_until([&] { return count<fw::Connected>() > 0 && firmware.reporting; });
  }

  template <typename T>
  int count() const {
    int n = 0;
    for (const fw::Event& event : events) n += std::holds_alternative<T>(event.what) ? 1 : 0;
    return n;
  }
  /// The n-th event of a kind, which must exist.
  template <typename T>
  const T& get(int n = 0) const {
    return std::get<T>(event_of<T>(n).what);
  }
  template <typename T>
  const fw::Event& event_of(int n = 0) const {
    for (const fw::Event& event : events) {
      if (std::holds_alternative<T>(event.what) && n-- == 0) return event;
    }
    throw std::logic_error("no such event");
  }
  /// What the firmware executed of a print, without the host's own handshake.
  std::vector<std::string> printed() const {
    std::vector<std::string> out = firmware.executed;
    std::erase_if(out, [](const std::string& line) {
      return line == "M115" || line == "M503" || line == "M211" || line.starts_with("M113") ||
             line.starts_with("M155") || line.starts_with("M110") || line == "M105";
    });
    return out;
  }

  FakeClock clock;
  fw::FlightRecorder recorder;
  ModelFirmware firmware;
  fw::marlin::Driver driver;
  std::vector<fw::Event> events;
  double t = 0;
  std::vector<std::string> raw;                        ///< everything the driver wrote, line by line
  std::function<std::string(std::string)> to_printer;  ///< damages a line on its way; may return nothing
  std::function<std::string(std::string)> to_host;
  std::function<double(const std::string&)> duration = [](const std::string& command) {
    return command.starts_with("M109") || command.starts_with("M190") ? 20.0 : 0.01;
  };
  bool mute = false;  ///< the firmware says nothing
  bool says_busy = true;

 private:
  void note(const fw::Event& event) { events.push_back(event); }

  void step() {
    bool moved = write();
    moved |= firmware.pull();
    moved |= run_command();
    for (const std::string& line : std::exchange(firmware.replies, {})) {
      const std::string arrived = to_host ? to_host(line) : line;
      if (!mute && !arrived.empty()) driver.received(arrived + "\n", t);
      moved = true;
    }
    if (t >= driver.deadline()) driver.elapsed(t), moved = true;
    if (moved) return advance(t + 1e-4);
    double next = std::min(driver.deadline(), t + 1);
    if (firmware.front()) next = std::min({next, finish_t_, busy_t_});
    advance(std::max(next, t + 1e-4));
  }

  bool write() {
    std::string output = std::exchange(driver.output(), {});
    if (output.empty()) return false;
    if (!to_printer) firmware.receive(output);
    for (const char c : output) {
      begun_ += c;
      if (c != '\n') continue;
      raw.push_back(std::exchange(begun_, {}));
      if (to_printer) firmware.receive(to_printer(raw.back()));
    }
    return true;
  }

  bool run_command() {
    const std::string* command = firmware.front();
    if (!command) return false;
    if (!running_) {
      running_ = true;
      finish_t_ = t + duration(*command);
      busy_t_ = t + 2;
    }
    const bool heating = command->starts_with("M109") || command->starts_with("M190");
    if (heating && std::exchange(firmware.break_wait, false)) finish_t_ = t;
    if (t >= finish_t_) {
      running_ = false;
      firmware.execute();
      return true;
    }
    if (t >= busy_t_) {
      busy_t_ = t + 2;
      if (says_busy) firmware.replies.push_back("echo:busy: processing");
      if (heating) firmware.replies.push_back(" T:100.00 /200.00 B:20.00 /0.00 @:127 B@:0 W:?");
      return true;
    }
    return false;
  }

  void advance(double to) { t = clock.now = to; }

  std::string begun_;  ///< a line of which the end is still to come
  bool running_ = false;
  double finish_t_ = 0;
  double busy_t_ = 0;
};

}  // namespace voidpath::test

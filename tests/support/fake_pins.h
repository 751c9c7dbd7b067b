#pragma once

#include "firmware-io/gpio/pins.h"

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <sys/eventfd.h>
#include <unistd.h>

namespace voidpath::test {

/// Pins of straw behind the interface of the real ones, known by their line's name. Any thread.
class FakePins final : public fw::Pins {
 public:
  struct Line {
    std::mutex mutex;
    bool active = false;
    bool taken = false;
    std::string failure;  ///< what every call from now on throws; empty: it works
    std::deque<fw::Edge> edges;
    std::vector<bool> driven;  ///< what an output was set to, the first time included
    fw::PinOptions options;
    std::string use;
    const int fd = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC | EFD_SEMAPHORE);

    ~Line() { ::close(fd); }
    void wake() {
      const std::uint64_t one = 1;
      [[maybe_unused]] const auto written = ::write(fd, &one, sizeof one);
    }
    void check() const {
      if (!failure.empty()) throw fw::PinError(failure);
    }
  };

  /// Sets an input as its owner means it, with the edge that goes with it.
  void set(const std::string& name, bool active, double at_s = 0) {
    Line& line = at(name);
    const std::lock_guard lock(line.mutex);
    if (line.active == active) return;
    line.active = active;
    if (!line.taken) return;
    line.edges.push_back({active, at_s});
    line.wake();
  }
  /// The level changes and the edge is lost.
  void set_silently(const std::string& name, bool active) {
    Line& line = at(name);
    const std::lock_guard lock(line.mutex);
    line.active = active;
  }
  bool active(const std::string& name) {
    Line& line = at(name);
    const std::lock_guard lock(line.mutex);
    return line.active;
  }
  std::vector<bool> driven(const std::string& name) {
    Line& line = at(name);
    const std::lock_guard lock(line.mutex);
    return line.driven;
  }
  bool taken(const std::string& name) {
    Line& line = at(name);
    const std::lock_guard lock(line.mutex);
    return line.taken;
  }
  void fail(const std::string& name, const std::string& why) {
    Line& line = at(name);
    const std::lock_guard lock(line.mutex);
    line.failure = why;
    line.wake();
  }
  fw::PinOptions options(const std::string& name) { return at(name).options; }

  std::unique_ptr<fw::InputPin> input(const fw::PinOptions& pin, const std::string& use) override {
    return std::make_unique<Input>(take(pin, use));
  }
  std::unique_ptr<fw::OutputPin> output(const fw::PinOptions& pin, const std::string& use,
                                        bool active) override {
    auto out = std::make_unique<Output>(take(pin, use));
    out->set(active);
    return out;
  }

 private:
  using LinePtr = std::shared_ptr<Line>;

  struct Taken {
    explicit Taken(LinePtr p) : line(std::move(p)) {}
    ~Taken() {
      const std::lock_guard lock(line->mutex);
      line->taken = false;
      line->edges.clear();
    }
    Taken(const Taken&) = delete;
    Taken& operator=(const Taken&) = delete;
    LinePtr line;
  };
  class Input final : public fw::InputPin, Taken {
   public:
    using Taken::Taken;
    bool active() const override {
      const std::lock_guard lock(line->mutex);
      line->check();
      return line->active;
    }
    int fd() const noexcept override { return line->fd; }
    std::optional<fw::Edge> next_edge() override {
      const std::lock_guard lock(line->mutex);
      std::uint64_t count = 0;
      if (::read(line->fd, &count, sizeof count) < 0) count = 0;
      line->check();
      if (line->edges.empty()) return std::nullopt;
      const fw::Edge out = line->edges.front();
      line->edges.pop_front();
      return out;
    }
  };
  class Output final : public fw::OutputPin, Taken {
   public:
    using Taken::Taken;
    void set(bool active) override {
      const std::lock_guard lock(line->mutex);
      line->check();
      line->active = active;
      line->driven.push_back(active);
    }
    bool active() const override {
      const std::lock_guard lock(line->mutex);
      return line->active;
    }
  };

  LinePtr take(const fw::PinOptions& pin, const std::string& use) {
    at(pin.line);
    const LinePtr line = lines_.at(pin.line);
    const std::lock_guard lock(line->mutex);
    line->check();
    if (line->taken) throw fw::PinError("pin " + fw::describe(pin) + ": Device or resource busy");
    line->taken = true;
    line->options = pin;
    line->use = use;
    return line;
  }
  Line& at(const std::string& name) {
    const std::lock_guard lock(mutex_);
    LinePtr& line = lines_[name];
    if (!line) line = std::make_shared<Line>();
    return *line;
  }

  std::mutex mutex_;  ///< guards lines_, not what they point at
  std::map<std::string, LinePtr> lines_;
};

}  // namespace voidpath::test

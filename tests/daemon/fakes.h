#pragma once

#include "daemon/executor.h"
#include "daemon/jobs/runner.h"
#include "tests/daemon/temp_dir.h"
#include "tests/support/fake_pins.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <poll.h>

namespace voidpath::test {

/// The loop, turned by hand, with a clock that only moves when told.
class ManualLoop final : public daemon::Executor {
 public:
  void post(Task task) override {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    posted_.notify_all();
  }
  TimerId after(double seconds, Task task) override {
    timers_[++last_] = {now_ + seconds, std::move(task)};
    return last_;
  }
  void cancel(TimerId timer) noexcept override { timers_.erase(timer); }
  void add_fd(int fd, Task task) override { readers_[fd] = std::move(task); }
  void remove_fd(int fd) noexcept override { readers_.erase(fd); }
  double now_s() const noexcept override { return now_; }

  /// Runs all that is posted and readable, and what that leads to.
  void run() {
    for (;;) {
      std::vector<Task> tasks;
      {
        const std::lock_guard lock(mutex_);
        tasks.swap(tasks_);
      }
      for (const auto& [fd, task] : readers_) {
        pollfd waiting{fd, POLLIN, 0};
        if (::poll(&waiting, 1, 0) > 0) tasks.push_back(task);
      }
      if (tasks.empty()) return;
      for (const auto& task : tasks) task();
    }
  }
  /// Runs until the condition holds, waiting for other threads to post. False after ten seconds.
  bool run_until(const std::function<bool()>& holds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    for (run(); !holds(); run()) {
      std::unique_lock lock(mutex_);
      if (!posted_.wait_until(lock, end, [&] { return !tasks_.empty(); })) return false;
    }
    return true;
  }
  void advance(double seconds) {
    now_ += seconds;
    std::vector<Task> due;
    for (auto it = timers_.begin(); it != timers_.end();) {
      if (it->second.first <= now_) {
        due.push_back(std::move(it->second.second));
        it = timers_.erase(it);
      } else {
        ++it;
      }
    }
    for (const auto& task : due) task();
    run();
  }

 private:
  std::mutex mutex_;
  std::condition_variable posted_;
  std::vector<Task> tasks_;
  std::map<int, Task> readers_;
  std::map<TimerId, std::pair<double, Task>> timers_;
  TimerId last_ = 0;
  double now_ = 0;
};

/// What the printer was told; what it says is said by the test.
struct FakePrinter {
  std::vector<std::string> calls;
  fw::PrinterPort::Handler handler;
  double now_s = 100;

  template <typename What>
  void say(What what, double later_s = 0) {
    now_s += later_s;
    handler(fw::Event{now_s, std::move(what)});
  }
  std::size_t count(const std::string& call) const {
    return static_cast<std::size_t>(std::count(calls.begin(), calls.end(), call));
  }
};

class FakePort final : public fw::PrinterPort {
 public:
  explicit FakePort(FakePrinter& printer) : printer_(printer) {}
  void print(std::unique_ptr<fw::LineSource>) override { printer_.calls.push_back("print"); }
  void pause() override { printer_.calls.push_back("pause"); }
  void resume() override { printer_.calls.push_back("resume"); }
  void cancel(std::string) override { printer_.calls.push_back("cancel"); }
  void halt(std::string) override { printer_.calls.push_back("halt"); }
  void forget_halt() override { printer_.calls.push_back("forget_halt"); }
  void command(std::string line) override { printer_.calls.push_back("command " + line); }
  std::vector<std::string> dialogue() const override { return {"> M105", "< ok"}; }

 private:
  FakePrinter& printer_;
};

class EmptySource final : public fw::LineSource {
 public:
  std::optional<fw::SourceLine> next() override { return std::nullopt; }
  std::uint64_t position() const noexcept override { return 0; }
  std::uint64_t size() const noexcept override { return 1000; }
};

/// A runner with a store on disk and a printer of straw. restart() is a crash: nothing is told to anyone.
class RunnerRig {
 public:
  explicit RunnerRig(bool auto_clear = false, config::PinsConfig wired = {}) {
    config.state_dir = dir / "state";
    std::filesystem::create_directories(config.state_dir);
    config::PrinterConfig left;
    left.name = "left";
    left.watch = {dir / "inbox"};
    left.auto_clear = auto_clear;
    left.pins = std::move(wired);
    std::filesystem::create_directories(left.watch[0]);
    config.printers = {left};
    prepare = [](const daemon::PrepareTask& task, const run::Context&) {
      daemon::PrepareResult result;
      result.kind = daemon::PrepareResult::Kind::prepared;
      result.copies = std::max(1, task.options.copies);
      result.facts.method = "toolpath";
      result.facts.profile_sha256 = "p";
      result.facts.predicted_raw_s = result.facts.predicted_s = 100;
      result.facts.layer_times = {{0.2, 10, 50}, {0.4, 20, 50}};
      result.facts.layers = 2;
      std::filesystem::create_directories(task.gcode_out.parent_path());
      std::ofstream(task.gcode_out) << "G28\n";
      return result;
    };
    boot();
  }

  void boot() {
    store = std::make_unique<daemon::JobStore>(config.state_dir / "voidpath.db");
    settler = std::make_unique<daemon::Settler>(1.0, daemon::real_probe());
    daemon::PortServices port;
    port.open_port = [this](fw::PortOptions, std::shared_ptr<const fw::Clock>,
                            fw::PrinterPort::Handler handler) {
      printer.handler = std::move(handler);
      return std::make_unique<FakePort>(printer);
    };
    port.open_source = [this](const std::filesystem::path& file) -> std::unique_ptr<fw::LineSource> {
      if (!std::filesystem::exists(file)) throw std::runtime_error("cannot read " + file.string());
      return std::make_unique<EmptySource>();
    };
    port.open_clock = [](const config::PrinterConfig&) { return std::shared_ptr<const fw::Clock>(); };
    runner = std::make_unique<daemon::Runner>(
        daemon::Runner::Services{loop, *store, *settler, log,
                                 [this](const auto& task, const auto& ctx) { return prepare(task, ctx); },
                                 port, [this](const config::PrinterConfig&) { return port_options; }, &pins},
        config);
    runner->start();
    loop.run();
  }
  void restart() {
    runner.reset();
    settler.reset();
    store.reset();
    boot();
  }
  void connect() {
    fw::FirmwareInfo info;
    info.name = "Marlin test";
    printer.say(fw::Connected{info});
    loop.run();
  }
  /// Puts a file in the folder and tells the runner that it settled.
  std::filesystem::path drop(const std::string& name, const std::string& text = "solid\nendsolid\n") {
    const auto file = dir.write("inbox/" + name, text);
    runner->take({file, *daemon::identify(file)});
    return file;
  }
  bool reaches(const std::string& name, daemon::State state) {
    return loop.run_until([&] { return state_of(name) == state; });
  }
  std::optional<daemon::State> state_of(const std::string& name) const {
    for (const auto* job : runner->queue()) {
      if (job->file_name() == name) return job->state;
    }
    return std::nullopt;
  }
  daemon::JobId id_of(const std::string& name) const {
    for (const auto* job : runner->queue()) {
      if (job->file_name() == name) return job->id;
    }
    return 0;
  }
  /// From heating to the first move.
  void begin_motion() {
    printer.say(fw::PrintStarted{});
    printer.say(fw::Heating{true}, 1);
    printer.say(fw::Heating{false}, 30);
    printer.say(fw::MotionStarted{}, 1);
    loop.run();
  }
  void finish(double motion_s) {
    printer.say(fw::LineDone{10, 100}, motion_s / 4);
    printer.say(fw::LineDone{20, 200}, motion_s / 4);
    printer.say(fw::PrintFinished{}, motion_s / 2);
    loop.run();
  }

  TempDir dir;
  config::DaemonConfig config;
  fw::PortOptions port_options;
  ManualLoop loop;
  FakePins pins;
  daemon::EventLog log{{}, false};
  FakePrinter printer;
  daemon::PrepareFunction prepare;
  std::unique_ptr<daemon::JobStore> store;
  std::unique_ptr<daemon::Settler> settler;
  std::unique_ptr<daemon::Runner> runner;
};

}  // namespace voidpath::test

#include "tests/bench/stream/our_host.h"

#include "firmware-io/printer_port.h"
#include "tests/bench/stream/wire_printer.h"

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <mutex>
#include <thread>
#include <utility>

namespace voidpath::bench {
namespace {

/// What happened so far, for the main thread to wait on.
struct Progress {
  std::mutex mutex;
  std::condition_variable changed;
  bool connected = false, started = false, over = false, finished = false;
  CpuUse before, cpu;  ///< of the whole process, for the print alone

  void note(const fw::Event& event) {
    const bool known = std::holds_alternative<fw::LimitsKnown>(event.what);
    const bool began = std::holds_alternative<fw::PrintStarted>(event.what);
    const bool done = std::holds_alternative<fw::PrintFinished>(event.what);
    const auto* failed = std::get_if<fw::PrintFailed>(&event.what);
    if (failed) std::fprintf(stderr, "our host: %s\n", failed->reason.c_str());
    if (!known && !began && !done && !failed) return;
    const std::lock_guard lock(mutex);
    if (began) before = cpu_use();
    if (done) cpu = cpu_use() - before;
    connected |= known;
    started |= began;
    finished |= done;
    over |= done || failed != nullptr;
    changed.notify_all();
  }
  void wait_for(bool Progress::*what) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return this->*what; });
  }
};

fw::PortOptions options(const std::string& port, int baud, bool meatpack) {
  fw::PortOptions o;
  o.port = port;
  o.baud = baud;
  o.meatpack = meatpack;
  o.boot_wait_s = 0.05;
  return o;
}

}  // namespace

int print_file(const std::string& port, int baud, bool meatpack, const std::string& file, int window) {
  Progress progress;
  fw::PortOptions with = options(port, baud, meatpack);
  with.rx_bytes = window + 1;
  const auto printer = fw::open_marlin(std::move(with), fw::steady_clock(),
                                       [&](const fw::Event& event) { progress.note(event); });
  progress.wait_for(&Progress::connected);
  printer->print(fw::open_gcode_file(file));
  progress.wait_for(&Progress::over);
  std::printf("%.6f %.6f %.0f\n", progress.cpu.user_s, progress.cpu.kernel_s, progress.cpu.sleeps);
  return progress.finished ? 0 : 1;
}

int stop_print(const std::string& port, int baud, const std::string& file, double after_s) {
  Progress progress;
  const auto printer = fw::open_marlin(options(port, baud, false), fw::steady_clock(),
                                       [&](const fw::Event& event) { progress.note(event); });
  progress.wait_for(&Progress::connected);
  printer->print(fw::open_gcode_file(file));
  progress.wait_for(&Progress::started);
  std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
  const double called_s = monotonic_s();
  printer->halt("stop");
  progress.wait_for(&Progress::over);
  std::printf("%.9f\n", called_s);
  return 0;
}

}  // namespace voidpath::bench

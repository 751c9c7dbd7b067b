#include "tests/bench/stream/memory_host.h"

#include "firmware-io/clock.h"
#include "firmware-io/flight_recorder.h"
#include "firmware-io/marlin/driver.h"
#include "firmware-io/printer_port.h"

#include <algorithm>
#include <stdexcept>
#include <string_view>

namespace voidpath::bench {
namespace {

constexpr double kLimit_s = 60;

/// Says what a Marlin would, of what it is told: `ok` to each line, temperatures where they are wanted.
class Answers {
 public:
  // Lines begin with N and a number, or with a command.
  void take(std::string_view bytes) {
    for (const char c : bytes) {
      if (c != '\n') {
        if (length_++ < kKept) line_[length_ - 1] = c;
        continue;
      }
      if (length_ > 0) answer({line_, std::min(length_, kKept)});
      length_ = 0;
    }
  }
  std::string& said() { return said_; }

 private:
  static constexpr std::size_t kKept = 24;

  void answer(std::string_view line) {
    if (line.find("M115") != line.npos) said_ += "FIRMWARE_NAME:Marlin 2.1.2 MACHINE_TYPE:memory\n";
    said_ += line.find("M105") != line.npos ? "ok T:20.00 /0.00 B:20.00 /0.00 @:0 B@:0\n" : "ok\n";
  }

  char line_[kKept];
  std::size_t length_ = 0;
  std::string said_;
};

}  // namespace

CpuUse print_in_memory(const std::string& file, int window) {
  bool connected = false, over = false, finished = false;
  CpuUse before, after;
  fw::FlightRecorder recorder;
  const auto clock = fw::steady_clock();
  fw::marlin::DriverOptions options;
  options.window.max_bytes = window;
  options.meatpack = false;
  options.handshake.boot_wait_s = options.handshake.settle_s = 0.01;
  const auto note = [&](const fw::Event& event) {
    connected |= std::holds_alternative<fw::Connected>(event.what);
    if (std::holds_alternative<fw::PrintStarted>(event.what)) before = cpu_use();
    if (std::holds_alternative<fw::PrintFinished>(event.what)) after = cpu_use(), over = finished = true;
    over |= std::holds_alternative<fw::PrintFailed>(event.what);
  };
  fw::marlin::Driver driver(options, *clock, recorder, note);
  Answers printer;
  std::string said;
  bool printing = false;
  driver.opened(clock->now_s());
  const double latest = clock->now_s() + kLimit_s;
  while (!over && !driver.closing() && clock->now_s() < latest) {
    printer.take(driver.output());
    driver.output().clear();
    said.swap(printer.said());
    if (!said.empty()) driver.received(said, clock->now_s());
    said.clear();
    const double now = clock->now_s();
    if (now >= driver.deadline()) driver.elapsed(now);
    if (connected && !printing) {
      printing = true;
      driver.print(fw::open_gcode_file(file), now);
    }
  }
  if (!finished) throw std::runtime_error("the print in memory did not finish");
  return after - before;
}

}  // namespace voidpath::bench

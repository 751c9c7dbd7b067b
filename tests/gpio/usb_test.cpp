#include "firmware-io/printer_port.h"
#include "tests/firmware-io/driver_bench.h"
#include "tests/firmware-io/spaced.h"
#include "tests/gpio/usb_printer.h"

#include <algorithm>
#include <condition_variable>

#include <catch2/catch.hpp>

using namespace voidpath::fw;
using voidpath::test::MemorySource;
using voidpath::test::UsbPrinter;

namespace {

/// What the session told, for whoever waits for it.
class Told {
 public:
  void operator()(const Event& event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
    changed_.notify_all();
  }
  template <class What>
  bool comes(long times = 1) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(30), [&] {
      return times <= std::count_if(events_.begin(), events_.end(),
                                    [](const Event& e) { return std::holds_alternative<What>(e.what); });
    });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Event> events_;
};

std::vector<std::string> moves(int count) {
  std::vector<std::string> out;
  for (int i = 0; i < count; ++i) out.push_back("G1 X" + std::to_string(i % 100) + " F6000");
  return out;
}

std::vector<std::string> only_moves(std::vector<std::string> lines) {
  for (std::string& line : lines) line = voidpath::test::spaced(line);
  std::erase_if(lines, [](const std::string& line) { return !line.starts_with("G1 "); });
  return lines;
}

}  // namespace

TEST_CASE("a USB printer is found, pulled in mid-print, plugged in again and prints", "[usb]") {
  UsbPrinter printer;
  Told told;
  PortOptions options;
  options.port = "/dev/ttyACM0";
  options.baud = 250000;
  options.boot_wait_s = 0.3;
  options.reconnect_s = 0.1;
  const auto port = open_marlin(options, steady_clock(), [&](const Event& event) { told(event); });
  REQUIRE(told.comes<Connected>());
  port->print(std::make_unique<MemorySource>(moves(20000)));
  REQUIRE(told.comes<LineDone>(100));

  printer.unplug();
  REQUIRE(told.comes<PrintFailed>());
  REQUIRE(told.comes<Disconnected>());
  CHECK_FALSE(std::filesystem::exists("/dev/ttyACM0"));
  // Each line up to the cut was executed once, in order.
  const auto before = only_moves(printer.executed());
  const auto all = moves(20000);
  REQUIRE(before.size() >= 100);
  REQUIRE(before.size() < all.size());
  CHECK(std::equal(before.begin(), before.end(), all.begin()));

  printer.plug();
  REQUIRE(told.comes<Connected>(2));
  port->print(std::make_unique<MemorySource>(moves(200)));
  REQUIRE(told.comes<PrintFinished>());
  CHECK(only_moves(printer.executed()) == moves(200));
}

TEST_CASE("a printer that is plugged in only later is found by itself", "[usb]") {
  Told told;
  PortOptions options;
  options.port = "/dev/ttyACM0";
  options.boot_wait_s = 0.3;
  options.reconnect_s = 0.1;
  const auto port = open_marlin(options, steady_clock(), [&](const Event& event) { told(event); });
  REQUIRE(told.comes<Disconnected>());
  UsbPrinter printer;
  CHECK(told.comes<Connected>());
}

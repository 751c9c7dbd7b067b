#pragma once

#include "firmware-io/transport/raw_tty.h"
#include "tests/gpio/sim_chip.h"
#include "tests/mock_printer/mock_marlin.h"

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <poll.h>

namespace voidpath::test {

/// A printer on a real USB cable within one machine: a CDC-ACM gadget on the kernel's dummy controller, with
/// the mock firmware at its end. The host sees /dev/ttyACM0.
class UsbPrinter {
 public:
  UsbPrinter() : root_("/sys/kernel/config/usb_gadget/printer") {
    namespace fs = std::filesystem;
    fs::create_directory(root_);
    write_file(root_ / "idVendor", "0x1d50");
    write_file(root_ / "idProduct", "0x6029");
    fs::create_directory(root_ / "strings/0x409");
    write_file(root_ / "strings/0x409/serialnumber", "42");
    fs::create_directory(root_ / "functions/acm.usb0");
    fs::create_directory(root_ / "configs/c.1");
    fs::create_directory_symlink(root_ / "functions/acm.usb0", root_ / "configs/c.1/acm.usb0");
    thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
    plug();
  }
  ~UsbPrinter() {
    unplug();
    thread_.request_stop();
    thread_.join();
    ::unlink((root_ / "configs/c.1/acm.usb0").c_str());
    for (const char* part : {"configs/c.1", "functions/acm.usb0", "strings/0x409", ""})
      ::rmdir((root_ / part).c_str());
  }
  UsbPrinter(const UsbPrinter&) = delete;
  UsbPrinter& operator=(const UsbPrinter&) = delete;

  void plug() { write_file(root_ / "UDC", "dummy_udc.0"); }
  void unplug() { write_file(root_ / "UDC", "\n"); }
  /// All it has executed since it was last plugged in.
  std::vector<std::string> executed() {
    const std::lock_guard lock(mutex_);
    return executed_;
  }

 private:
  static mock::Options options() {
    mock::Options out;
    out.cold_extrusion = true;
    return out;
  }

  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const int fd = ::open("/dev/ttyGS0", O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
      if (fd >= 0 && fw::make_raw(fd, 250000) == 0) serve(fd, stop);
      if (fd >= 0) ::close(fd);
    }
  }

  // From one power-up to the pulled cable. The printer's time runs a hundred times as fast as ours.
  void serve(int fd, const std::stop_token& stop) {
    mock::MockMarlin printer(options());
    printer.on_command([this](std::string_view line) {
      const std::lock_guard lock(mutex_);
      executed_.emplace_back(line);
    });
    const auto begun = std::chrono::steady_clock::now();
    std::string out;
    bool served = false;
    while (!stop.stop_requested()) {
      pollfd waiting{fd, POLLIN, 0};
      ::poll(&waiting, 1, 2);
      char buffer[4096];
      const auto got = ::read(fd, buffer, sizeof buffer);
      if (got == 0 || (got < 0 && errno != EAGAIN)) return;
      if (got > 0 && !std::exchange(served, true)) {
        const std::lock_guard lock(mutex_);
        executed_.clear();
      }
      if (got > 0) printer.feed({buffer, static_cast<std::size_t>(got)});
      const std::chrono::duration<double> real = std::chrono::steady_clock::now() - begun;
      printer.advance_to(real.count() * 100);
      out += printer.take_output();
      if (const auto sent = ::write(fd, out.data(), out.size()); sent > 0)
        out.erase(0, static_cast<std::size_t>(sent));
    }
  }

  std::filesystem::path root_;
  std::mutex mutex_;  ///< guards executed_
  std::vector<std::string> executed_;
  std::jthread thread_;
};

}  // namespace voidpath::test

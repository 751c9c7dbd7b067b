#pragma once

#include "firmware-io/marlin/session.h"
#include "firmware-io/session.h"
#include "firmware-io/transport/loopback.h"
#include "tests/firmware-io/driver_prints.h"

#include <array>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include <poll.h>

/// Sessions on real threads, with a model firmware at the other end of the cable.
namespace voidpath::test {

// No test waits for this long unless it fails.
inline constexpr auto kPatience = std::chrono::seconds(20);

/// The model firmware on a thread of its own, answering at once, behind any transport.
class Peer {
 public:
  explicit Peer(std::unique_ptr<fw::Transport> transport) : transport_(std::move(transport)) {
    thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
  }
  ~Peer() { pull_cable(); }

  /// From now on it reads nothing and says nothing.
  void fall_deaf() {
    if (!thread_.joinable()) return;
    thread_.request_stop();
    thread_.join();
  }
  void pull_cable() {
    fall_deaf();
    transport_.reset();
  }
  void reset() {
    const std::lock_guard lock(mutex_);
    reset_ = true;
    hold_at_.clear();
  }
  /// From this command on nothing is executed: the queue stands.
  void hold_at(std::string command) {
    const std::lock_guard lock(mutex_);
    hold_at_ = std::move(command);
  }
  bool wait_for(const std::function<bool(const ModelFirmware&)>& condition) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return condition(firmware_); });
  }
  /// Waits until it has heard M112.
  bool dies() {
    return wait_for([](const ModelFirmware& firmware) { return firmware.dead; });
  }
  Lines executed() {
    const std::lock_guard lock(mutex_);
    return firmware_.executed;
  }

 private:
  void run(const std::stop_token& stop) {
    std::array<char, 4096> buffer;
    while (!stop.stop_requested()) {
      pollfd fd{transport_->fd(), POLLIN, 0};
      ::poll(&fd, 1, 2);
      const std::lock_guard lock(mutex_);
      if (std::exchange(reset_, false)) firmware_.reset();
      try {
        while (const auto n = transport_->read(buffer)) take({buffer.data(), n});
      } catch (const fw::PortError&) {
        return;  // the host closed its end
      }
      work();
      changed_.notify_all();
    }
  }

  // Byte by byte, as a ring that is emptied while it fills.
  void take(std::string_view bytes) {
    for (const char c : bytes) {
      firmware_.receive({&c, 1});
      firmware_.pull();
      work();
    }
  }

  void work() {
    do {
      firmware_.pull();
      while (firmware_.front() && *firmware_.front() != hold_at_) firmware_.execute();
    } while (firmware_.pull());
    std::string out;
    for (const std::string& line : std::exchange(firmware_.replies, {})) out += line + "\n";
    try {
      if (!out.empty()) transport_->write(out);
    } catch (const fw::PortError&) {
      // The next read says so too.
    }
  }

  std::unique_ptr<fw::Transport> transport_;
  std::mutex mutex_;  ///< guards all below
  std::condition_variable changed_;
  ModelFirmware firmware_;
  std::string hold_at_;
  bool reset_ = false;
  std::jthread thread_;
};

/// Collects events on the session's thread and lets the test wait for them.
class Listener {
 public:
  fw::PrinterPort::Handler handler() {
    return [this](const fw::Event& event) {
      const std::lock_guard lock(mutex_);
      events_.push_back(event);
      changed_.notify_all();
    };
  }
  template <typename T>
  bool wait_for(int n = 1) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return count_locked<T>() >= n; });
  }
  template <typename T>
  int count() {
    const std::lock_guard lock(mutex_);
    return count_locked<T>();
  }
  template <typename T>
  T last() {
    const std::lock_guard lock(mutex_);
    for (auto event = events_.rbegin(); event != events_.rend(); ++event) {
      if (const T* found = std::get_if<T>(&event->what)) return *found;
    }
    throw std::logic_error("no such event");
  }

 private:
  template <typename T>
  int count_locked() const {
    int n = 0;
    for (const fw::Event& event : events_) n += std::holds_alternative<T>(event.what) ? 1 : 0;
    return n;
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<fw::Event> events_;
};

inline fw::marlin::SessionOptions quick() {
  fw::marlin::SessionOptions options;
  options.driver.handshake.boot_wait_s = 0.02;
  options.driver.handshake.banner_quiet_s = 0.02;
  options.driver.handshake.settle_s = 0.01;
  options.reconnect_s = 0.02;
  return options;
}

inline std::unique_ptr<fw::LineSource> source(Lines lines) {
  return std::make_unique<MemorySource>(std::move(lines));
}

/// A session whose port is a loopback; each opening gets a fresh firmware behind it.
struct SessionRig {
  explicit SessionRig(fw::marlin::SessionOptions options = quick()) {
    port = fw::marlin::start_session(
        std::move(options), [this] { return open(); }, fw::steady_clock(), listener.handler());
  }
  std::unique_ptr<fw::Transport> open() {
    const std::lock_guard lock(mutex);
    if (!plugged) throw fw::PortError("test port: unplugged");
    fw::Loopback loopback = fw::make_loopback();
    peers.push_back(std::make_unique<Peer>(std::move(loopback.device)));
    changed.notify_all();
    return std::move(loopback.host);
  }
  /// Who is behind the n-th opening, counted from 1. Waits for it.
  Peer& peer(std::size_t n = 1) {
    std::unique_lock lock(mutex);
    if (!changed.wait_for(lock, kPatience, [&] { return peers.size() >= n; }))
      throw std::runtime_error("the port was not opened again");
    return *peers[n - 1];
  }
  /// Connects and prints for so long that the printer stands at the file's 51st line.
  bool print_to_hold() {
    if (!listener.wait_for<fw::Connected>()) return false;
    const Lines file = moves(500);
    peer().hold_at(file[50]);
    port->print(source(file));
    return listener.wait_for<fw::LineDone>(50);
  }
  void unplug() {
    const std::lock_guard lock(mutex);
    plugged = false;
    peers.back()->pull_cable();
  }
  void plug() {
    const std::lock_guard lock(mutex);
    plugged = true;
  }
  /// Connects, and stops when the port is gone.
  bool halt_unplugged() {
    if (!listener.wait_for<fw::Connected>()) return false;
    unplug();
    if (!listener.wait_for<fw::Disconnected>()) return false;
    port->halt("button");
    return true;
  }

  std::mutex mutex;  ///< guards peers and plugged
  std::condition_variable changed;
  bool plugged = true;
  std::vector<std::unique_ptr<Peer>> peers;  ///< one for each opening
  Listener listener;
  std::unique_ptr<fw::PrinterPort> port;  ///< last: its thread uses all above
};

}  // namespace voidpath::test

#include "firmware-io/marlin/session.h"

#include "firmware-io/session.h"
#include "firmware-io/transport/fd_transport.h"
#include "firmware-io/transport/loopback.h"
#include "tests/firmware-io/driver_bench.h"

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <mutex>
#include <thread>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

using namespace voidpath::fw;
using voidpath::test::MemorySource;
using voidpath::test::ModelFirmware;

namespace {

using Lines = std::vector<std::string>;

// No test waits for this long unless it fails.
constexpr auto kPatience = std::chrono::seconds(20);

/// The model firmware on a thread of its own, answering at once, behind any transport.
class Peer {
 public:
  explicit Peer(std::unique_ptr<Transport> transport) : transport_(std::move(transport)) {
    thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
  }
  ~Peer() { pull_cable(); }

  void pull_cable() {
    if (!thread_.joinable()) return;
    thread_.request_stop();
    thread_.join();
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
      } catch (const PortError&) {
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
    } catch (const PortError&) {
      // The next read says so too.
    }
  }

  std::unique_ptr<Transport> transport_;
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
  PrinterPort::Handler handler() {
    return [this](const Event& event) {
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
    for (const Event& event : events_) n += std::holds_alternative<T>(event.what) ? 1 : 0;
    return n;
  }
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Event> events_;
};

marlin::SessionOptions quick() {
  marlin::SessionOptions options;
  options.driver.handshake.boot_wait_s = 0.02;
  options.driver.handshake.banner_quiet_s = 0.02;
  options.driver.handshake.settle_s = 0.01;
  options.reconnect_s = 0.02;
  return options;
}

Lines moves(int n) {
  Lines out;
  for (int i = 0; i < n; ++i) out.push_back("G1 X" + std::to_string(i) + " E" + std::to_string(i * 3));
  return out;
}

std::unique_ptr<LineSource> source(Lines lines) { return std::make_unique<MemorySource>(std::move(lines)); }

/// A session whose port is a loopback; each opening gets a fresh firmware behind it.
struct Rig {
  explicit Rig(marlin::SessionOptions options = quick()) {
    port = marlin::start_session(
        std::move(options), [this] { return open(); }, steady_clock(), listener.handler());
  }
  std::unique_ptr<Transport> open() {
    const std::lock_guard lock(mutex);
    if (!plugged) throw PortError("test port: unplugged");
    Loopback loopback = make_loopback();
    peer = std::make_unique<Peer>(std::move(loopback.device));
    ++opened;
    changed.notify_all();
    return std::move(loopback.host);
  }
  /// Connects and prints for so long that the printer stands at the file's 51st line.
  bool print_to_hold() {
    if (!listener.wait_for<Connected>()) return false;
    peer->hold_at("G1 X50 E150");
    port->print(source(moves(500)));
    return listener.wait_for<LineDone>(50);
  }
  /// Waits until the printer has heard M112.
  bool printer_dies() {
    return peer->wait_for([](const ModelFirmware& firmware) { return firmware.dead; });
  }
  void unplug() {
    const std::lock_guard lock(mutex);
    plugged = false;
    peer->pull_cable();
  }
  void plug() {
    const std::lock_guard lock(mutex);
    plugged = true;
  }
  /// Connects, and stops when the port is gone.
  bool halt_unplugged() {
    if (!listener.wait_for<Connected>()) return false;
    unplug();
    if (!listener.wait_for<Disconnected>()) return false;
    port->halt("button");
    return true;
  }
  /// Waits for the second peer.
  bool reopened() {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, kPatience, [&] { return opened == 2; });
  }

  std::mutex mutex;  ///< guards peer, plugged and opened
  std::condition_variable changed;
  bool plugged = true;
  int opened = 0;
  std::unique_ptr<Peer> peer;
  Listener listener;
  std::unique_ptr<PrinterPort> port;  ///< last: its thread uses all above
};

/// Closes the port whenever it is told to halt.
struct Halter final : Dialogue {
  struct Script {
    std::function<void()> opened = [] {}, shut_down = [] {};
    int unheard = 0;  ///< so many halts the printer does not hear
    std::atomic<int> halts{0};
  };
  explicit Halter(Script& s) : script(s) {}
  void opened(double /*t*/) override {
    closed = heard = false;
    script.opened();
  }
  void halt(const std::string& /*reason*/, double /*t*/) override {
    closed = true;
    heard = ++script.halts > script.unheard;
  }
  void shut_down(double /*t*/) override { script.shut_down(); }
  bool halt_heard() const noexcept override { return heard; }
  bool closing() const noexcept override { return closed; }
  bool finished() const noexcept override { return true; }
  double deadline() const noexcept override { return closed ? 0 : 1e300; }
  std::string& output() noexcept override { return out; }
  bool take_urgent() noexcept override { return false; }
  void received(std::string_view /*bytes*/, double /*t*/) override {}
  void elapsed(double /*t*/) override {}
  void lost(const std::string& /*reason*/) override {}
  void print(std::unique_ptr<LineSource> /*source*/, double /*t*/) override {}
  void pause() override {}
  void resume(double /*t*/) override {}
  void cancel(const std::string& /*reason*/, double /*t*/) override {}
  void command(const std::string& /*text*/, double /*t*/) override {}

  Script& script;
  bool closed = false, heard = false;
  std::string out;
};

/// Behind it there are loopbacks without a printer.
std::unique_ptr<PrinterPort> halter_session(Halter::Script& script, std::vector<Loopback>& opened) {
  const auto open = [&opened] {
    opened.push_back(make_loopback());
    return std::move(opened.back().host);
  };
  const auto make = [&script](const Clock&, FlightRecorder&, const PrinterPort::Handler&) {
    return std::make_unique<Halter>(script);
  };
  return start_session(
      {.reconnect_s = 0.001}, open, steady_clock(), [](const Event&) {}, make);
}

Lines printed(Peer& peer) {
  Lines out = peer.executed();
  std::erase_if(out, [](const std::string& line) {
    return line == "M115" || line == "M503" || line == "M211" || line.starts_with("M113") ||
           line.starts_with("M155") || line.starts_with("M110") || line == "M105";
  });
  return out;
}

}  // namespace

TEST_CASE("a session prints a file over a loopback", "[session]") {
  Rig rig;
  REQUIRE(rig.listener.wait_for<Connected>());
  CHECK(rig.listener.last<Connected>().firmware.machine == "Model Machine");
  Lines file = moves(2000);
  rig.port->print(source(file));
  REQUIRE(rig.listener.wait_for<PrintFinished>());
  file.push_back("M400");
  CHECK(printed(*rig.peer) == file);
  CHECK(rig.listener.count<LineDone>() == 2000);
  const auto dialogue = rig.port->dialogue();
  REQUIRE(dialogue.size() > 300);
  CHECK(dialogue.back().find("< ok") != std::string::npos);
}

TEST_CASE("a pulled cable fails the print, and the port comes back by itself", "[session]") {
  Rig rig;
  REQUIRE(rig.print_to_hold());
  rig.unplug();
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  REQUIRE(rig.listener.wait_for<Disconnected>());
  CHECK(rig.listener.last<PrintFailed>().reason.find("connection lost") == 0);
  REQUIRE(rig.listener.wait_for<Disconnected>(2));  // now because it cannot be opened
  CHECK(rig.listener.last<Disconnected>().reason == "test port: unplugged");
  rig.plug();
  REQUIRE(rig.listener.wait_for<Connected>(2));
  rig.port->print(source(moves(5)));
  REQUIRE(rig.listener.wait_for<PrintFinished>());
}

TEST_CASE("a printer reset in mid-print is printed on by nobody", "[session]") {
  Rig rig;
  REQUIRE(rig.print_to_hold());
  rig.peer->reset();
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  REQUIRE(rig.listener.wait_for<Connected>(2));
  CHECK(printed(*rig.peer).size() < 60);
}

TEST_CASE("pause, resume and cancel reach a running print", "[session]") {
  Rig rig;
  REQUIRE(rig.print_to_hold());
  rig.port->pause();
  REQUIRE(rig.listener.wait_for<Paused>());
  rig.peer->hold_at("G1 X200 E600");
  rig.port->resume();
  REQUIRE(rig.listener.wait_for<Resumed>());
  REQUIRE(rig.listener.wait_for<LineDone>(200));
  rig.port->cancel("enough");
  rig.peer->hold_at("");
  REQUIRE(rig.listener.wait_for<PrintCancelled>());
  const Lines all = printed(*rig.peer);
  const Lines end{"M104 S0", "M140 S0", "M107", "M84"};
  REQUIRE(all.size() > 204);
  CHECK(Lines(all.end() - 4, all.end()) == end);
  CHECK(all.size() < 215);
}

TEST_CASE("halt reaches a firmware whose queue is full", "[session]") {
  Rig rig;
  REQUIRE(rig.listener.wait_for<Connected>());
  rig.port->print(source(moves(100000)));
  REQUIRE(rig.listener.wait_for<LineDone>(50));
  rig.port->halt("button");
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  REQUIRE(rig.listener.wait_for<Disconnected>());
  CHECK(rig.listener.last<PrintFailed>().reason == "button");
  CHECK(rig.listener.last<Disconnected>().reason == "button");
  CHECK(rig.printer_dies());
}

TEST_CASE("destruction ends a running print with the heaters off", "[session]") {
  auto rig = std::make_unique<Rig>();
  REQUIRE(rig->listener.wait_for<Connected>());
  rig->port->print(source(moves(1000000)));
  REQUIRE(rig->listener.wait_for<LineDone>(50));
  rig->port.reset();
  CHECK(rig->listener.count<PrintCancelled>() == 1);
  const Lines all = printed(*rig->peer);
  const Lines end{"M104 S0", "M140 S0", "M107", "M84"};
  REQUIRE(all.size() > 50);
  CHECK(Lines(all.end() - 4, all.end()) == end);
}

TEST_CASE("destruction does not wait long for a printer that hangs", "[session]") {
  marlin::SessionOptions options = quick();
  options.shutdown_s = 0.05;
  Rig rig(options);
  REQUIRE(rig.print_to_hold());
  const auto begun = std::chrono::steady_clock::now();
  rig.port.reset();
  CHECK(std::chrono::steady_clock::now() - begun < std::chrono::seconds(5));
}

TEST_CASE("a missing port is reported with its name", "[session]") {
  Listener listener;
  PortOptions options;
  options.port = "/dev/no-such-printer";
  options.reconnect_s = 0.01;
  const auto port = open_marlin(options, steady_clock(), listener.handler());
  REQUIRE(listener.wait_for<Disconnected>());
  CHECK(listener.last<Disconnected>().reason.find("/dev/no-such-printer") != std::string::npos);
  port->print(source(moves(2)));
  REQUIRE(listener.wait_for<PrintFailed>());
}

TEST_CASE("a file goes through a pseudo terminal at a Marlin's odd baud rate", "[session]") {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  REQUIRE(master >= 0);
  REQUIRE(::grantpt(master) == 0);
  REQUIRE(::unlockpt(master) == 0);
  const std::string slave = ::ptsname(master);
  const int keep_open =
      ::open(slave.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // else the master hangs up at once
  REQUIRE(keep_open >= 0);
  Peer peer(std::make_unique<FdTransport>(master, "pty master"));
  Listener listener;
  PortOptions options;
  options.port = slave;
  options.baud = 250000;
  options.boot_wait_s = 0.05;
  options.reconnect_s = 0.05;
  const auto port = open_marlin(options, steady_clock(), listener.handler());
  REQUIRE(listener.wait_for<Connected>());
  Lines file = moves(500);
  port->print(source(file));
  REQUIRE(listener.wait_for<PrintFinished>());
  file.push_back("M400");
  CHECK(printed(peer) == file);

  Listener second;
  const auto rival = open_marlin(options, steady_clock(), second.handler());
  REQUIRE(second.wait_for<Disconnected>());
  CHECK(second.last<Disconnected>().reason.find("in use") != std::string::npos);
  ::close(keep_open);
}

TEST_CASE("an emergency stop while the port is gone is the first that goes out when it is back",
          "[session]") {
  Rig rig;
  REQUIRE(rig.halt_unplugged());
  rig.plug();
  REQUIRE(rig.reopened());
  CHECK(rig.printer_dies());
  CHECK(rig.peer->executed().empty());
}

TEST_CASE("an emergency stop that a person has seen to is not said to the printer when its port is back",
          "[session]") {
  Rig rig;
  REQUIRE(rig.halt_unplugged());
  rig.port->forget_halt();
  rig.port->print(source(moves(1)));
  REQUIRE(rig.listener.wait_for<PrintFailed>());  // all before it has been carried out
  rig.plug();
  REQUIRE(rig.listener.wait_for<Connected>(2));
  CHECK(rig.reopened());  // and no third time
}

TEST_CASE("an emergency stop that the cable took with it is said again", "[session]") {
  Rig rig;
  REQUIRE(rig.print_to_hold());
  rig.port->halt("button");
  REQUIRE(rig.listener.wait_for<PrintFailed>());
  rig.unplug();
  rig.plug();
  REQUIRE(rig.reopened());
  CHECK(rig.printer_dies());
}

TEST_CASE("an emergency stop that was heard is not said to the next printer", "[session]") {
  Rig rig;
  REQUIRE(rig.listener.wait_for<Connected>());
  rig.port->halt("button");
  REQUIRE(rig.printer_dies());
  REQUIRE(rig.reopened());
  REQUIRE(rig.listener.wait_for<Connected>(2));
}

TEST_CASE("an emergency stop that comes while its session ends still goes out", "[session]") {
  Halter::Script script;
  std::vector<Loopback> loopbacks;
  std::promise<void> opened;
  PrinterPort* stopped = nullptr;
  script.opened = [&] { opened.set_value(); };
  script.shut_down = [&] { stopped->halt("button"); };
  auto port = halter_session(script, loopbacks);
  stopped = port.get();
  REQUIRE(opened.get_future().wait_for(kPatience) == std::future_status::ready);
  port.reset();
  CHECK(script.halts == 1);
}

TEST_CASE("an emergency stop is said anew at each opening until the printer has heard it", "[session]") {
  Halter::Script script;
  script.unheard = 1;
  std::vector<Loopback> loopbacks;
  std::promise<void> opened, opened_again;
  int openings = 0;
  script.opened = [&] {
    if (++openings == 1) opened.set_value();
    if (openings == 3) opened_again.set_value();
  };
  auto port = halter_session(script, loopbacks);
  REQUIRE(opened.get_future().wait_for(kPatience) == std::future_status::ready);
  port->halt("button");
  REQUIRE(opened_again.get_future().wait_for(kPatience) == std::future_status::ready);
  port.reset();
  CHECK(script.halts == 2);
}

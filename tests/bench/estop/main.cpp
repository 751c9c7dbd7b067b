// From the edge of an emergency-stop switch to the power cut and to M112 in the printer's port, while G-code
// is streamed at 250000 baud. Everything is real but the pin and the printer: the switch's thread, the
// session's thread, a pseudo-terminal, and the mock firmware on the wall's clock behind it.
#include "firmware-io/gpio/emergency_stop.h"
#include "firmware-io/gpio/relay.h"
#include "firmware-io/marlin/session.h"
#include "firmware-io/printer_port.h"
#include "firmware-io/transport/serial_port.h"
#include "tests/mock_printer/mock_marlin.h"
#include "tests/mock_printer/pty.h"
#include "tests/support/fake_pins.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <thread>

#include <unistd.h>

using namespace voidpath;

namespace {

constexpr int kBaud = 250000;
constexpr int kSamples = 300;
constexpr double kLimit_ms = 5;
/// The switch is pulled after so many acknowledged lines and up to as many more: anywhere in the stream.
constexpr int kLinesBefore = 100;
constexpr auto kPatience = std::chrono::seconds(120);

double now_s() { return fw::steady_clock()->now_s(); }

/// A port that notes when M112 was handed to it.
class Watched final : public fw::Transport {
 public:
  Watched(std::unique_ptr<fw::Transport> port, std::atomic<double>& at) : port_(std::move(port)), at_(at) {}
  int fd() const noexcept override { return port_->fd(); }
  std::size_t read(std::span<char> into) override { return port_->read(into); }
  std::size_t write(std::string_view bytes) override {
    const std::size_t taken = port_->write(bytes);
    if (bytes.substr(0, taken).find("M112") != bytes.npos && at_ == 0) at_ = now_s();
    return taken;
  }
  void drop_output() noexcept override { port_->drop_output(); }

 private:
  std::unique_ptr<fw::Transport> port_;
  std::atomic<double>& at_;
};

/// Short moves without end, as a curve is: the wire is what limits them.
class Curve final : public fw::LineSource {
 public:
  std::optional<fw::SourceLine> next() override {
    const std::uint32_t n = n_++;
    if (n == 0) return fw::SourceLine{"G1 F60000", n};
    char line[64];
    std::snprintf(line, sizeof line, "G1 X%u.%03u Y%u.%03u E0.%05u", 50 + n % 100, n % 1000, 50 + n % 97,
                  n * 7 % 1000, 1000 + n % 500);
    return fw::SourceLine{line, n};
  }
  std::uint64_t position() const noexcept override { return n_; }
  std::uint64_t size() const noexcept override { return 1u << 30; }

 private:
  std::uint32_t n_ = 0;
};

/// The mock firmware behind a pseudo-terminal, its clock the wall's.
class Printer {
 public:
  explicit Printer(const std::string& link) : pty_(link) {
    thread_ = std::jthread([this](std::stop_token stop) { run(stop); });
  }

 private:
  void run(const std::stop_token& stop) {
    test::mock::Options options;
    options.baud = kBaud;
    options.round_trip_s = 0.001;
    options.cold_extrusion = true;
    options.motion.max_speed = {5000, 5000, 5000, 5000};
    options.motion.max_acceleration = {1e7, 1e7, 1e7, 1e7};
    options.motion.print_acceleration = options.motion.travel_acceleration = 1e7;
    options.motion.junction_deviation = 10;
    test::mock::MockMarlin printer(options);
    const double begun = now_s();
    std::string in, out;
    while (!stop.stop_requested()) {
      in.clear();
      pty_.read(in);
      if (!in.empty()) printer.feed(in);
      printer.advance_to(now_s() - begun);
      out += printer.take_output();
      pty_.write(out);
      pty_.wait(0.0005);
    }
  }
  test::mock::Pty pty_;
  std::jthread thread_;
};

struct Sample {
  double cut_ms = 0, m112_ms = 0;
};

Sample take_sample(const std::string& link, int lines) {
  const Printer printer(link);
  std::atomic<double> m112_at{0};
  std::mutex mutex;
  std::condition_variable changed;
  int done = 0;
  bool connected = false, reported = false;
  fw::marlin::SessionOptions options;
  options.driver.byte_s = 10.0 / kBaud;
  options.driver.handshake.boot_wait_s = 0.02;
  options.driver.handshake.banner_quiet_s = 0.02;
  const auto port = fw::marlin::start_session(
      options, [&] { return std::make_unique<Watched>(fw::open_serial_port(link, kBaud), m112_at); },
      fw::steady_clock(),
      [&](const fw::Event& event) {
        const std::lock_guard lock(mutex);
        connected = connected || std::holds_alternative<fw::Connected>(event.what);
        done += std::holds_alternative<fw::LineDone>(event.what) ? 1 : 0;
        changed.notify_all();
      });
  test::FakePins pins;
  fw::Relay relay(pins.output({"", "relay", false, fw::Bias::as_is}, "bench", false));
  relay.on();
  double cut_at = 0;
  fw::EmergencyStopActions actions;
  actions.cut = [&] {
    relay.cut();
    cut_at = now_s();
  };
  actions.halt = [&] { port->halt("bench"); };
  actions.report = [&](bool, const std::string&) {
    const std::lock_guard lock(mutex);
    reported = true;
    changed.notify_all();
  };
  const fw::EmergencyStop stop(pins.input({"", "stop", false, fw::Bias::as_is}, "bench"), {},
                               std::move(actions));
  const auto wait = [&](auto condition) {
    std::unique_lock lock(mutex);
    if (!changed.wait_for(lock, kPatience, condition))
      throw std::runtime_error("the mock printer does not answer");
  };
  wait([&] { return connected; });
  port->print(std::make_unique<Curve>());
  wait([&] { return done >= lines; });
  const double edge_at = now_s();
  pins.set("stop", true, edge_at);
  wait([&] { return reported; });
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (m112_at == 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (m112_at == 0) throw std::runtime_error("M112 never came");
  return {(cut_at - edge_at) * 1000, (m112_at - edge_at) * 1000};
}

double at(const std::vector<double>& sorted, double share) {
  return sorted[std::min(sorted.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
}

}  // namespace

int main(int argc, char** argv) {
  int samples = kSamples;
  if (argc > 1) std::from_chars(argv[1], argv[1] + std::strlen(argv[1]), samples);
  const auto dir = std::filesystem::temp_directory_path() / ("voidpath-estop-" + std::to_string(::getpid()));
  std::filesystem::create_directory(dir);
  std::vector<double> cut, m112;
  try {
    for (int i = 0; i < std::max(1, samples); ++i) {
      const Sample one = take_sample((dir / "port").string(), kLinesBefore + i * 37 % kLinesBefore);
      cut.push_back(one.cut_ms);
      m112.push_back(one.m112_ms);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_estop: %s\n", error.what());
    std::filesystem::remove_all(dir);
    return 1;
  }
  std::filesystem::remove_all(dir);
  std::array<double, 1> load{};
  ::getloadavg(load.data(), 1);
  std::printf("%zu stops while streaming at %d baud, load %.1f; ms from the edge\n", m112.size(), kBaud,
              load[0]);
  for (auto& [name, values] : {std::pair("relay off", &cut), {"M112 in the port", &m112}}) {
    std::sort(values->begin(), values->end());
    std::printf("  %-17s median %.3f  p99 %.3f  worst %.3f\n", name, at(*values, 0.5), at(*values, 0.99),
                values->back());
  }
  return at(m112, 0.99) <= kLimit_ms ? 0 : 1;
}

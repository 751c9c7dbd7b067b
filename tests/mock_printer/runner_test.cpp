#include "tests/mock_printer/runner.h"

#include "tests/mock_printer/host_for_test.h"

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <thread>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

using namespace voidpath::test::mock;

namespace {

struct TempDir {
  TempDir() {
    char name[] = "/tmp/mock-test-XXXXXX";
    if (::mkdtemp(name) != nullptr) path = name;
  }
  ~TempDir() { std::filesystem::remove_all(path); }
  std::string file(const char* name) const { return path + "/" + name; }
  std::string path;
};

/// A mock on its pty, in a thread of its own.
class Live {
 public:
  Live(const Options& printer, RunnerOptions options)
      : runner_(printer, options), thread_([this] { runner_.run(requests); }) {}
  ~Live() { stop(); }
  void stop() {
    requests.stop = true;
    if (thread_.joinable()) thread_.join();
  }
  /// Only after `stop`.
  Statistics statistics() const { return runner_.printer().statistics(); }
  RunnerRequests requests;

 private:
  Runner runner_;
  std::thread thread_;
};

/// The simplest host: one line in flight over the port.
class PortHost {
 public:
  explicit PortHost(const std::string& path) : fd_(::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    REQUIRE(fd_ >= 0);
  }
  ~PortHost() { ::close(fd_); }
  PortHost(const PortHost&) = delete;
  PortHost& operator=(const PortHost&) = delete;

  void write(std::string_view bytes) {
    REQUIRE(::write(fd_, bytes.data(), bytes.size()) == ssize_t(bytes.size()));
  }
  /// Reads until `what` was heard; false after so long a silence or when the port is gone.
  bool hear(std::string_view what, int silence_ms = 10000) {
    for (;;) {
      if (const auto at = heard_.find(what); at != heard_.npos) {
        heard_.erase(0, at + what.size());
        return true;
      }
      pollfd p{fd_, POLLIN, 0};
      if (::poll(&p, 1, silence_ms) <= 0) return false;
      char buffer[4096];
      const ssize_t n = ::read(fd_, buffer, sizeof buffer);
      if (n <= 0) return false;
      heard_.append(buffer, static_cast<std::size_t>(n));
    }
  }
  bool run(std::string_view command) {
    write(numbered(++number_, command));
    return hear("ok");
  }

 private:
  int fd_;
  std::int64_t number_ = 0;
  std::string heard_;
};

std::vector<std::string> zigzag(int lines) {
  std::vector<std::string> result;
  for (int i = 0; i < lines; ++i)
    result.push_back("G1 X" + std::to_string(20 + (i % 7) * 3) + " Y" + std::to_string(20 + (i * 5) % 11) +
                     " F6000");
  result.push_back("M400");
  return result;
}

double motion_seconds(double speed, int lines) {
  TempDir dir;
  Live mock(make_mock().build(), {.link = dir.file("port"), .speed = speed});
  PortHost host(dir.file("port"));
  for (const std::string& line : zigzag(lines)) REQUIRE(host.run(line));
  mock.stop();
  CHECK(mock.statistics().resends == 0);
  return mock.statistics().motion_s;
}

}  // namespace

TEST_CASE("the motion takes the same time at any speed of the clock") {
  // Long enough that a first block that waited for its successors makes no difference.
  const double real = motion_seconds(1, 12), fast = motion_seconds(60, 12), jumping = motion_seconds(0, 12);
  CHECK(real > 1);
  CHECK(fast == Approx(real).epsilon(1e-3));
  CHECK(jumping == Approx(fast).epsilon(1e-9));
  CHECK(motion_seconds(60, 1500) == Approx(motion_seconds(0, 1500)).epsilon(1e-9));
}

TEST_CASE("log and clock are written, the greeting waits for the first host") {
  TempDir dir;
  Live mock(
      make_mock().build(),
      {.link = dir.file("port"), .speed = 0, .clock_file = dir.file("clock"), .log_file = dir.file("log")});
  CHECK(std::filesystem::file_size(dir.file("clock")) == 16);
  PortHost host(dir.file("port"));
  CHECK(host.hear("start\n"));
  for (const char* line : {"G28", "G1 X10 F3000", "M400"}) CHECK(host.run(line));
  std::ifstream log(dir.file("log"));
  const std::string text{std::istreambuf_iterator<char>(log), {}};
  CHECK(text == "G28\nG1 X10 F3000\nM400\n");
  std::ifstream clock(dir.file("clock"), std::ios::binary);
  clock.seekg(8);
  double seconds = 0;
  clock.read(reinterpret_cast<char*>(&seconds), 8);
  CHECK(seconds > 3);
  CHECK(seconds < 10);
}

TEST_CASE("a host may go and come back; the print's state stays") {
  TempDir dir;
  Live mock(make_mock().build(), {.link = dir.file("port"), .speed = 0});
  {
    PortHost first(dir.file("port"));
    CHECK(first.run("M104 S200"));
  }
  PortHost second(dir.file("port"));
  second.write("\nN0 M110 N0*125\n");
  CHECK(second.hear("ok"));
  CHECK(second.run("M105"));
  CHECK(second.hear("/200.00"));
}

TEST_CASE("opening the port resets a board that is wired so") {
  TempDir dir;
  Live mock(make_mock().build(), {.link = dir.file("port"), .speed = 0, .reset_on_open = true});
  {
    PortHost first(dir.file("port"));
    CHECK(first.hear("start\n"));
    CHECK(first.run("M104 S200"));
  }
  PortHost second(dir.file("port"));
  CHECK(second.hear("start\n"));
  CHECK(second.run("M105"));
  CHECK(second.hear("/0.00"));
}

TEST_CASE("a pulled cable ends the port and comes back under the same name") {
  TempDir dir;
  Fault pull;
  pull.kind = FaultKind::kUnplug;
  pull.at = 2;
  pull.seconds = 0.05;
  Live mock(make_mock().fault(pull).build(), {.link = dir.file("port"), .speed = 0});
  {
    PortHost host(dir.file("port"));
    CHECK(host.run("G90"));
    host.write(numbered(2, "G91"));
    host.hear("ok");
    CHECK_FALSE(host.hear("never said"));
  }
  while (!std::filesystem::exists(dir.file("port"))) std::this_thread::yield();
  PortHost again(dir.file("port"));
  again.write("N0 M110 N0*125\n");
  CHECK(again.hear("ok"));
}

TEST_CASE("the mock takes thousands of lines a second", "[.bench]") {
  TempDir dir;
  Live mock(make_mock().build(), {.link = dir.file("port"), .speed = 0});
  PortHost host(dir.file("port"));
  const auto lines = zigzag(100000);
  const auto begin = std::chrono::steady_clock::now();
  for (const std::string& line : lines) REQUIRE(host.run(line));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("%.0f lines/s\n", static_cast<double>(lines.size()) / took.count());
  CHECK(took.count() > 0);
}

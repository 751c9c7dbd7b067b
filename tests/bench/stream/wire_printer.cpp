#include "tests/bench/stream/wire_printer.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

namespace voidpath::bench {
namespace {

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

struct Terminal {
  int master = -1, slave = -1;
  std::string path;

  Terminal() {
    master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0) fail("pty");
    path = ::ptsname(master);
    slave = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // kept open: the host may come and go
    if (slave < 0) fail(path.c_str());
    termios raw{};
    ::tcgetattr(slave, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(slave, TCSANOW, &raw);
  }
  ~Terminal() { ::close(slave), ::close(master); }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
};

pid_t start(const std::vector<std::string>& command, int out) {
  const pid_t child = ::fork();
  if (child < 0) fail("fork");
  if (child > 0) return child;
  ::dup2(out, STDOUT_FILENO);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// What a host says last: three numbers.
CpuUse last_use(const std::string& output) {
  const auto end = output.find_last_not_of(" \r\n");
  if (end == output.npos) return {};
  const auto line = output.find_last_of("\r\n", end);
  CpuUse use;
  std::sscanf(output.c_str() + (line == output.npos ? 0 : line + 1), "%lf %lf %lf", &use.user_s,
              &use.kernel_s, &use.sleeps);
  return use;
}

std::string read_all(int fd) {
  std::string all;
  char buffer[4096];
  for (ssize_t n; (n = ::read(fd, buffer, sizeof buffer)) > 0;)
    all.append(buffer, static_cast<std::size_t>(n));
  return all;
}

class Run {
 public:
  Run(const test::mock::Options& options, std::string_view first, std::string_view last)
      : printer_(options), first_(first), last_(last) {
    printer_.on_command([this](std::string_view command) {
      outcome_.executed.emplace_back(command);
      if (command == first_) {
        started_ = true;
        begin_s_ = printer_.now();
        bytes_before_ = bytes_in_;
      }
      if (command == last_) {
        last_s_ = printer_.now();
        bytes_at_last_ = bytes_in_;
      }
    });
  }

  Outcome until_exit(pid_t child, double limit_s) {
    const double start = monotonic_s();
    for (int turn = 0;; ++turn) {
      const double now = monotonic_s() - start;
      printer_.advance_to(now);
      receive(now);
      send();
      rusage usage{};
      int status = 0;
      if (turn % 16 == 0 && ::wait4(child, &status, WNOHANG, &usage) == child) {
        finish(status, usage);
        return outcome_;
      }
      if (now > limit_s) ::kill(child, SIGKILL);
      wait_until(start, printer_.next_event());
    }
  }

  int master() const { return terminal_.master; }
  const std::string& path() const { return terminal_.path; }

 private:
  void receive(double now) {
    char buffer[4096];
    const ssize_t n = ::read(terminal_.master, buffer, sizeof buffer);
    if (n <= 0) return;
    bytes_in_ += static_cast<std::uint64_t>(n);
    if (outcome_.halted_at_s < 0) {
      tail_.append(buffer, static_cast<std::size_t>(n));
      if (tail_.find("M112") != tail_.npos) outcome_.halted_at_s = monotonic_s();
      tail_.erase(0, tail_.size() - std::min<std::size_t>(tail_.size(), 3));
    }
    printer_.feed({buffer, static_cast<std::size_t>(n)});
    printer_.advance_to(now);
  }
  void send() {
    out_ += printer_.take_output();
    if (out_.empty()) return;
    const ssize_t n = ::write(terminal_.master, out_.data(), out_.size());
    if (n > 0) out_.erase(0, static_cast<std::size_t>(n));
  }
  // As exactly as the kernel can: the wire's clock is what is measured against.
  void wait_until(double start, double next) {
    const double seconds = std::clamp(next - (monotonic_s() - start), 0.0, 0.02);
    if (seconds == 0) return;
    timespec time{0, static_cast<long>(seconds * 1e9)};
    pollfd fd{terminal_.master, POLLIN, 0};
    ::ppoll(&fd, 1, &time, nullptr);
  }
  void finish(int status, const rusage& usage) {
    const test::mock::Statistics s = printer_.statistics();
    outcome_.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
    outcome_.commands = s.commands;
    outcome_.resends = s.resends;
    outcome_.bytes_dropped = s.bytes_dropped;
    outcome_.resident_mb = static_cast<double>(usage.ru_maxrss) / 1024;
    outcome_.stream_s = last_s_ - begin_s_;
    outcome_.bytes = started_ ? bytes_at_last_ - bytes_before_ : 0;
  }

  Terminal terminal_;
  test::mock::MockMarlin printer_;
  std::string_view first_, last_;
  std::string tail_;  ///< of what was received, for a word cut in two
  std::string out_;
  Outcome outcome_;
  bool started_ = false;
  double begin_s_ = 0, last_s_ = 0;
  std::uint64_t bytes_in_ = 0, bytes_before_ = 0, bytes_at_last_ = 0;
};

}  // namespace

CpuUse cpu_use() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return {seconds(usage.ru_utime), seconds(usage.ru_stime), static_cast<double>(usage.ru_nvcsw)};
}

double cost_of_sleep_s() {
  constexpr int kSleeps = 300;
  const double before_s = cpu_use().total_s();
  for (int i = 0; i < kSleeps; ++i) {
    const timespec time{0, 3000000};
    ::nanosleep(&time, nullptr);
  }
  return (cpu_use().total_s() - before_s) / kSleeps;
}

bool take_precedence() {
  sched_param priority{};
  priority.sched_priority = ::sched_get_priority_min(SCHED_FIFO);
  return ::sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
}

double monotonic_s() {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Outcome run_host(const test::mock::Options& printer, std::vector<std::string> host, std::string_view first,
                 std::string_view last, double limit_s) {
  Run run(printer, first, last);
  for (std::string& word : host)
    if (word == "PORT") word = run.path();
  int pipe[2];
  if (::pipe2(pipe, O_CLOEXEC) != 0) fail("pipe");
  const pid_t child = start(host, pipe[1]);
  ::close(pipe[1]);
  Outcome outcome = run.until_exit(child, limit_s);
  outcome.output = read_all(pipe[0]);
  outcome.cpu = last_use(outcome.output);
  ::close(pipe[0]);
  return outcome;
}

}  // namespace voidpath::bench

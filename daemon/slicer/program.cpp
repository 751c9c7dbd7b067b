#include "daemon/slicer/program.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

/// Two processes: a keeper, forked from us, which never executes anything, and the program, its child. The
/// keeper waits for the program's end and for the end of file on a pipe that only we hold open; at either it
/// kills the program's whole group. So nothing is left whichever of the three dies first: were the program
/// killed by us alone, a daemon that is killed could not do it, and PR_SET_PDEATHSIG does not reach a
/// program's own children.
/// Between fork and exec only async-signal-safe calls: another thread may hold any lock.
namespace voidpath::daemon {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

/// Larger than any print; a program that writes more is out of its mind.
constexpr rlim_t kFileLimit_bytes = rlim_t{8} << 30;
constexpr int kNice = 10;

class Fd {
 public:
  explicit Fd(int fd = -1) noexcept : fd_(fd) {}
  Fd(Fd&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Fd& operator=(Fd&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Fd() { reset(); }
  void reset() noexcept {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }
  int get() const noexcept { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

Fd checked(int fd, const std::string& what) {
  if (fd < 0) fail(errno, what);
  return Fd(fd);
}

/// What the keeper tells at the end.
struct Report {
  int exec_error = 0;  ///< errno: the program did not start
  int status = 0;      ///< as of waitpid
};

/// All that the children need, made before the fork.
struct Plan {
  std::vector<char*> argv;
  std::vector<char*> envp;
  const char* folder;
  int log;
  int leash;    ///< end of file when we are gone or want the end
  int our_end;  ///< of the leash: nobody else may hold it
  int report;   ///< takes one Report
  rlim_t memory;
  int max_signal;
};

void limit(__rlimit_resource_t what, rlim_t value) {
  rlimit now{};
  if (::getrlimit(what, &now) != 0) return;
  const rlim_t most = now.rlim_max == RLIM_INFINITY || value < now.rlim_max ? value : now.rlim_max;
  const rlimit wanted{most, most};
  ::setrlimit(what, &wanted);
}

void default_signals(int max_signal) {
  struct sigaction plain {};
  plain.sa_handler = SIG_DFL;
  for (int s = 1; s < max_signal; ++s) ::sigaction(s, &plain, nullptr);
  sigset_t none;
  ::sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
}

/// The kernel then takes the slicer and not the daemon that runs a print.
void first_when_memory_ends() {
  const int fd = ::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC);
  if (fd < 0) return;
  [[maybe_unused]] const auto written = ::write(fd, "1000", 4);
  ::close(fd);
}

[[noreturn]] void become_program(const Plan& plan, pid_t keeper) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != keeper) ::_exit(127);  // it died before the line above took hold
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null < 0 || ::dup2(null, STDIN_FILENO) < 0 || ::dup2(plan.log, STDOUT_FILENO) < 0 ||
      ::dup2(plan.log, STDERR_FILENO) < 0 || ::chdir(plan.folder) != 0) {
    ::_exit(127);
  }
  if (plan.memory > 0) limit(RLIMIT_DATA, plan.memory);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_FSIZE, kFileLimit_bytes);
  ::setpriority(PRIO_PROCESS, 0, kNice);
  first_when_memory_ends();
  ::execve(plan.argv[0], plan.argv.data(), plan.envp.data());
  const Report report{errno, 0};
  [[maybe_unused]] const auto written = ::write(plan.report, &report, sizeof report);
  ::_exit(127);
}

/// Keeps only the files it needs: whatever else we hold open (the printer's port) must close when we close
/// it.
void drop_files(int keep_a, int keep_b, int keep_c) {
  int low = 3;
  int kept[] = {keep_a, keep_b, keep_c};
  if (kept[0] > kept[1]) std::swap(kept[0], kept[1]);
  if (kept[1] > kept[2]) std::swap(kept[1], kept[2]);
  if (kept[0] > kept[1]) std::swap(kept[0], kept[1]);
  for (const int fd : kept) {
    if (fd > low) ::syscall(SYS_close_range, low, fd - 1, 0);
    low = fd + 1;
  }
  ::syscall(SYS_close_range, low, ~0U, 0);
}

[[noreturn]] void keep(const Plan& plan, pid_t parent) {
  ::setpgid(0, 0);  // Ctrl-C on a terminal ends us; the leash tells the keeper
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  ::close(plan.our_end);
  default_signals(plan.max_signal);
  ::signal(SIGTERM, SIG_IGN);
  ::signal(SIGPIPE, SIG_IGN);
  if (::getppid() != parent) ::_exit(0);
  drop_files(plan.log, plan.leash, plan.report);

  const pid_t self = ::getpid();
  const pid_t program = ::fork();
  if (program < 0) {
    const Report report{errno, 0};
    [[maybe_unused]] const auto written = ::write(plan.report, &report, sizeof report);
    ::_exit(1);
  }
  if (program == 0) {
    default_signals(plan.max_signal);
    become_program(plan, self);
  }
  ::setpgid(program, program);  // both do it: whoever is first
  const int ended = static_cast<int>(::syscall(SYS_pidfd_open, program, 0));
  pollfd entries[] = {{plan.leash, POLLIN, 0}, {ended, POLLIN, 0}};
  while (ended >= 0 && ::poll(entries, 2, -1) < 0 && errno == EINTR) {
  }
  ::kill(-program, SIGKILL);
  Report report;
  while (::waitpid(program, &report.status, 0) < 0 && errno == EINTR) {
  }
  ::kill(-program, SIGKILL);  // what it forked while dying
  while (::waitpid(-1, nullptr, WNOHANG) > 0) {
  }
  [[maybe_unused]] const auto written = ::write(plan.report, &report, sizeof report);
  ::_exit(0);
}

std::vector<std::string> environment_of(const ProgramCall& call) {
  std::vector<std::string> out;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text = *entry;
    const std::string_view name = text.substr(0, text.find('='));
    // What systemd gives us is not for others to answer.
    bool replaced =
        name == "NOTIFY_SOCKET" || name == "WATCHDOG_PID" || name == "WATCHDOG_USEC" || name == "LISTEN_FDS";
    for (const auto& [key, value] : call.environment) replaced = replaced || name == key;
    if (!replaced) out.emplace_back(text);
  }
  for (const auto& [key, value] : call.environment) out.push_back(key + "=" + value);
  return out;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> out;
  for (std::string& word : words) out.push_back(word.data());
  out.push_back(nullptr);
  return out;
}

/// Waits for the report, the stop or the time.
ProgramEnd::Kind wait_for_end(int report, int stopped, double limit_s) {
  const auto end =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit_s));
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    if (left <= 0) return ProgramEnd::Kind::timed_out;
    pollfd entries[] = {{report, POLLIN, 0}, {stopped, POLLIN, 0}};
    if (::poll(entries, 2, static_cast<int>(left) + 1) < 0 && errno != EINTR) fail(errno, "poll");
    if (entries[1].revents != 0) return ProgramEnd::Kind::stopped;
    if (entries[0].revents != 0) return ProgramEnd::Kind::exited;
  }
}

/// The keeper's word: a program that could not be started is told twice, the errno first.
Report read_report(int fd) {
  Report first;
  ssize_t got = 0;
  while ((got = ::read(fd, &first, sizeof first)) < 0 && errno == EINTR) {
  }
  if (got != static_cast<ssize_t>(sizeof first)) first = {0, SIGKILL};  // the keeper itself was killed
  return first;
}

}  // namespace

fs::path find_program(const std::string& name) {
  const auto runs = [](const fs::path& file) {
    std::error_code ec;
    return fs::is_regular_file(file, ec) && ::access(file.c_str(), X_OK) == 0;
  };
  if (name.find('/') != std::string::npos) return runs(name) ? fs::absolute(name) : fs::path();
  const char* path = std::getenv("PATH");
  const std::string all = path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin";
  for (std::size_t begin = 0; begin <= all.size();) {
    const std::size_t colon = std::min(all.find(':', begin), all.size());
    if (colon > begin)
      if (const fs::path file = fs::path(all.substr(begin, colon - begin)) / name; runs(file))
        return fs::absolute(file);
    begin = colon + 1;
  }
  return {};
}

ProgramEnd run_program(const ProgramCall& call, const std::stop_token& stop) {
  std::vector<std::string> args = call.args;
  std::vector<std::string> environment = environment_of(call);
  const Fd log = checked(::open(call.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0600),
                         call.log.string());
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) fail(errno, "pipe");
  Fd leash_keeper(ends[0]);
  Fd leash_ours(ends[1]);
  if (::pipe2(ends, O_CLOEXEC) != 0) fail(errno, "pipe");
  const Fd report_ours(ends[0]);
  Fd report_keeper(ends[1]);
  const Fd stopped = checked(::eventfd(0, EFD_CLOEXEC), "eventfd");

  const Plan plan{pointers(args),      pointers(environment),   call.folder.c_str(),
                  log.get(),           leash_keeper.get(),      leash_ours.get(),
                  report_keeper.get(), call.memory_limit_bytes, SIGRTMAX + 1};
  const pid_t self = ::getpid();
  const pid_t keeper = ::fork();
  if (keeper < 0) fail(errno, "fork");
  if (keeper == 0) keep(plan, self);
  leash_keeper.reset();
  report_keeper.reset();

  const std::stop_callback on_stop(stop, [&] {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(stopped.get(), &one, sizeof one);
  });
  ProgramEnd out;
  out.kind = wait_for_end(report_ours.get(), stopped.get(), call.time_limit_s);
  leash_ours.reset();
  const Report report = read_report(report_ours.get());
  while (::waitpid(keeper, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (report.exec_error != 0) fail(report.exec_error, args[0]);
  if (out.kind != ProgramEnd::Kind::exited) return out;
  if (WIFEXITED(report.status)) return {ProgramEnd::Kind::exited, WEXITSTATUS(report.status)};
  return {ProgramEnd::Kind::killed, WTERMSIG(report.status)};
}

}  // namespace voidpath::daemon

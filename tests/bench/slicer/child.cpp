#include "tests/bench/slicer/child.h"

#include <cerrno>
#include <chrono>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace voidpath::bench {

namespace {

/// Waits until the process can be reaped; false when the time is up first.
bool wait_until_done(pid_t pid, double limit_s) {
  const int fd = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  if (fd < 0) throw std::system_error(errno, std::generic_category(), "pidfd_open");
  pollfd entry{fd, POLLIN, 0};
  int ready = 0;
  do {
    ready = ::poll(&entry, 1, static_cast<int>(limit_s * 1000));
  } while (ready < 0 && errno == EINTR);
  ::close(fd);
  return ready > 0;
}

}  // namespace

Usage run_child(const std::vector<std::string>& command, const std::filesystem::path& log, double limit_s) {
  // The kernel counts our own memory as the peak of what we start: it is a small program that starts it.
  const std::string account = log.string() + ".time";
  std::vector<std::string> words = {"time", "-q", "-f", "%U %S %M", "-o", account};
  words.insert(words.end(), command.begin(), command.end());
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const auto begin = std::chrono::steady_clock::now();
  pid_t pid = 0;
  const int error = ::posix_spawnp(&pid, argv[0], &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::system_error(error, std::generic_category(), words.front());

  Usage out;
  out.timed_out = !wait_until_done(pid, limit_s);
  if (out.timed_out) ::kill(-pid, SIGKILL);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  out.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  out.ok = !out.timed_out && WIFEXITED(status) && WEXITSTATUS(status) == 0;
  double user_s = 0, system_s = 0, peak_kb = 0;
  std::ifstream in(account);
  if (in >> user_s >> system_s >> peak_kb) {
    out.cpu_s = user_s + system_s;
    out.peak_mb = peak_kb / 1024;
  }
  return out;
}

}  // namespace voidpath::bench

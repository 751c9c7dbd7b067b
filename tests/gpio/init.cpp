// The first process of a user-mode Linux that runs one test program: mounts what that needs, runs it, says
// "RC=<exit code>" and switches the machine off. Never returns: the kernel would panic.
#include <cstdio>
#include <cstdlib>

#include <fcntl.h>
#include <sys/mount.h>
#include <sys/reboot.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

void mount_one(const char* type, const char* where) {
  ::mkdir(where, 0755);
  if (::mount(type, where, type, 0, nullptr) != 0) std::printf("init: cannot mount %s on %s\n", type, where);
}

int run(const char* program, const char* filter) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl(program, program, filter, nullptr);
    std::perror(program);
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

// What to run comes from the kernel's command line, by way of the environment.
int main() {
  mount_one("proc", "/proc");
  mount_one("sysfs", "/sys");
  mount_one("configfs", "/sys/kernel/config");
  mount_one("devtmpfs", "/dev");
  mount_one("devpts", "/dev/pts");
  const char* program = std::getenv("TEST_PROGRAM");
  std::printf("RC=%d\n", program != nullptr ? run(program, std::getenv("TEST_FILTER")) : 127);
  std::fflush(stdout);
  ::reboot(RB_POWER_OFF);
  for (;;) ::pause();
}

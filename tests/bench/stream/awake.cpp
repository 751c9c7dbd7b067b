#include "tests/bench/stream/awake.h"

#include <algorithm>
#include <thread>

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace voidpath::bench {
namespace {

[[noreturn]] void spin(pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(0);
  const sched_param none{};
  ::sched_setscheduler(0, SCHED_IDLE, &none);
  for (volatile unsigned turns = 0;;) turns = turns + 1;
}

}  // namespace

KeptAwake::KeptAwake() {
  const pid_t self = ::getpid();
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) {
    const pid_t child = ::fork();
    if (child == 0) spin(self);
    if (child > 0) spinners_.push_back(child);
  }
}

KeptAwake::~KeptAwake() {
  for (const pid_t child : spinners_) ::kill(child, SIGKILL), ::waitpid(child, nullptr, 0);
}

}  // namespace voidpath::bench

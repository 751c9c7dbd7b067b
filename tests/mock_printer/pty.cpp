#include "tests/mock_printer/pty.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/inotify.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

namespace voidpath::test::mock {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

timespec to_timespec(double seconds) {
  const double whole = std::floor(seconds);
  return {static_cast<time_t>(whole), static_cast<long>((seconds - whole) * 1e9)};
}

}  // namespace

Pty::Pty(std::string link) : link_(std::move(link)) { plug(); }

Pty::~Pty() { unplug(); }

void Pty::plug() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (master_ < 0) fail("posix_openpt");
  char name[128];
  if (::grantpt(master_) != 0 || ::unlockpt(master_) != 0 || ::ptsname_r(master_, name, sizeof name) != 0)
    fail("pty");
  // The line's settings live as long as the master does, so they can be made here, once.
  const int slave = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (slave < 0) fail(name);
  termios settings{};
  ::tcgetattr(slave, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(slave, TCSANOW, &settings);
  ::close(slave);
  watch_ = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (watch_ < 0 || ::inotify_add_watch(watch_, name, IN_OPEN | IN_CLOSE) < 0) fail(name);
  // Linked under a temporary name first: whoever looks sees the old port or the new one.
  const std::string fresh = link_ + ".new";
  ::unlink(fresh.c_str());
  if (::symlink(name, fresh.c_str()) != 0 || ::rename(fresh.c_str(), link_.c_str()) != 0) fail(link_);
  opens_ = 0;
  opened_ = ever_ = false;
  news_ = true;
}

void Pty::unplug() {
  if (master_ < 0) return;
  ::unlink(link_.c_str());
  ::close(master_);
  ::close(watch_);
  master_ = watch_ = -1;
  opens_ = 0;
}

void Pty::look_for_hosts() {
  news_ = false;
  alignas(inotify_event) char buffer[4096];
  const ssize_t n = ::read(watch_, buffer, sizeof buffer);
  for (ssize_t at = 0; at < n;) {
    const auto* event = reinterpret_cast<const inotify_event*>(buffer + at);
    at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    if ((event->mask & IN_OPEN) != 0 && ++opens_ == 1) opened_ = ever_ = true;
    if ((event->mask & IN_CLOSE) != 0 && opens_ > 0) --opens_;
  }
}

void Pty::read(std::string& into) {
  if (master_ < 0) return;
  // A look costs a system call; between two waits now and then is enough.
  constexpr unsigned kLookEvery = 16;
  if (news_ || ++reads_ % kLookEvery == 0) look_for_hosts();
  char buffer[4096];
  for (;;) {
    const ssize_t n = ::read(master_, buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;  // nothing there, or nobody has the other end open
    into.append(buffer, static_cast<std::size_t>(n));
    if (static_cast<std::size_t>(n) < sizeof buffer) return;
  }
}

void Pty::write(std::string& from) {
  // Before the first host comes the kernel keeps the greeting for it; later a closed port swallows all.
  if (master_ < 0 || (!connected() && ever_)) {
    from.clear();
    return;
  }
  while (!from.empty()) {
    const ssize_t n = ::write(master_, from.data(), from.size());
    if (n > 0) {
      from.erase(0, static_cast<std::size_t>(n));
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno != EAGAIN) from.clear();
    return;
  }
}

void Pty::wait(double seconds) {
  const timespec limit = to_timespec(std::max(seconds, 0.0));
  // While no host is there the port itself would report a hang-up again and again.
  pollfd p[2] = {{watch_, POLLIN, 0}, {master_, POLLIN, 0}};
  if (::ppoll(p, master_ < 0 ? 0 : connected() ? 2 : 1, &limit, nullptr) > 0) news_ = p[0].revents != 0;
}

bool Pty::take_opened() {
  const bool opened = opened_;
  opened_ = false;
  return opened;
}

}  // namespace voidpath::test::mock

#include "tests/mock_printer/pty.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
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
  // Linked under a temporary name first: whoever looks sees the old port or the new one.
  const std::string fresh = link_ + ".new";
  ::unlink(fresh.c_str());
  if (::symlink(name, fresh.c_str()) != 0 || ::rename(fresh.c_str(), link_.c_str()) != 0) fail(link_);
  connected_ = opened_ = ever_ = false;
}

void Pty::unplug() {
  if (master_ < 0) return;
  ::unlink(link_.c_str());
  ::close(master_);
  master_ = -1;
  connected_ = false;
}

void Pty::read(std::string& into) {
  if (master_ < 0) return;
  char buffer[4096];
  for (;;) {
    const ssize_t n = ::read(master_, buffer, sizeof buffer);
    if (n > 0) {
      into.append(buffer, static_cast<std::size_t>(n));
      if (!connected_) connected_ = opened_ = ever_ = true;
      if (static_cast<std::size_t>(n) == sizeof buffer) continue;
      return;
    }
    if (n < 0 && errno == EINTR) continue;
    const bool here = n < 0 && errno == EAGAIN;  // EIO: nobody has the other end open
    if (here && !connected_) opened_ = ever_ = true;
    connected_ = here;
    return;
  }
}

void Pty::write(std::string& from) {
  // Before the first host comes the kernel keeps the greeting for it; later a closed port swallows all.
  if (master_ < 0 || (!connected_ && ever_)) {
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

void Pty::wait(double seconds) const {
  // While no host is there poll() returns at once with a hang-up: look again a little later, s.
  constexpr double kLookAgain = 0.002;
  if (master_ < 0 || !connected_) {
    const timespec pause = to_timespec(std::clamp(seconds, 0.0, kLookAgain));
    ::nanosleep(&pause, nullptr);
    return;
  }
  pollfd p{master_, POLLIN, 0};
  const timespec limit = to_timespec(std::max(seconds, 0.0));
  ::ppoll(&p, 1, &limit, nullptr);
}

bool Pty::take_opened() {
  const bool opened = opened_;
  opened_ = false;
  return opened;
}

}  // namespace voidpath::test::mock

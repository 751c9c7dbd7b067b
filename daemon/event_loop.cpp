#include "daemon/event_loop.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <ctime>
#include <system_error>
#include <utility>

#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

namespace voidpath::daemon {
namespace {

[[noreturn]] void fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

sigset_t handled_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  return set;
}

}  // namespace

EventLoop::EventLoop() : epoll_(epoll_create1(EPOLL_CLOEXEC)), wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (epoll_ < 0 || wake_ < 0) fail("event loop");
  add_fd(wake_, [this] {
    std::uint64_t count = 0;
    while (::read(wake_, &count, sizeof count) > 0) {
    }
  });
}

EventLoop::~EventLoop() {
  if (wake_ >= 0) ::close(wake_);
  if (epoll_ >= 0) ::close(epoll_);
}

void EventLoop::post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    posted_.push_back(std::move(task));
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
}

void EventLoop::quit() noexcept {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
}

double EventLoop::now_s() const noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

Executor::TimerId EventLoop::after(double seconds, Task task) {
  timers_.emplace(++last_timer_, Timer{now_s() + std::max(0.0, seconds), std::move(task)});
  return last_timer_;
}

void EventLoop::cancel(TimerId timer) noexcept { timers_.erase(timer); }

void EventLoop::add_fd(int fd, Task task) {
  readers_[fd] = std::move(task);
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = fd;
  if (epoll_ctl(epoll_, EPOLL_CTL_ADD, fd, &event) != 0) fail("epoll_ctl");
}

void EventLoop::remove_fd(int fd) noexcept {
  epoll_ctl(epoll_, EPOLL_CTL_DEL, fd, nullptr);
  readers_.erase(fd);
}

int EventLoop::wait_ms() const {
  if (timers_.empty()) return -1;
  double first = timers_.begin()->second.due_s;
  for (const auto& [id, timer] : timers_) first = std::min(first, timer.due_s);
  return static_cast<int>(std::clamp(std::ceil((first - now_s()) * 1000), 0.0, 60'000.0));
}

void EventLoop::run_due() {
  const double now = now_s();
  std::vector<std::pair<double, TimerId>> due;
  for (const auto& [id, timer] : timers_) {
    if (timer.due_s <= now) due.emplace_back(timer.due_s, id);
  }
  std::sort(due.begin(), due.end());
  for (const auto& [when, id] : due) {
    const auto found = timers_.find(id);
    if (found == timers_.end()) continue;  // cancelled by an earlier one
    const Task task = std::move(found->second.task);
    timers_.erase(found);
    task();
  }
}

void EventLoop::run_posted() {
  std::vector<Task> tasks;
  {
    const std::lock_guard lock(mutex_);
    tasks.swap(posted_);
  }
  for (const auto& task : tasks) task();
}

void EventLoop::run() {
  std::array<epoll_event, 16> ready{};
  for (;;) {
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(quit_, false)) return;
    }
    const int count = epoll_wait(epoll_, ready.data(), static_cast<int>(ready.size()), wait_ms());
    if (count < 0 && errno != EINTR) fail("epoll_wait");
    for (int i = 0; i < count; ++i) {
      const auto reader = readers_.find(ready[static_cast<std::size_t>(i)].data.fd);
      if (reader == readers_.end()) continue;
      const Task task = reader->second;  // a copy: the task may remove itself
      task();
    }
    run_posted();
    run_due();
  }
}

void block_signals() {
  const sigset_t set = handled_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

int open_signal_fd() {
  const sigset_t set = handled_signals();
  const int fd = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  if (fd < 0) fail("signalfd");
  return fd;
}

int read_signal(int fd) noexcept {
  signalfd_siginfo info{};
  if (::read(fd, &info, sizeof info) != static_cast<ssize_t>(sizeof info)) return 0;
  return static_cast<int>(info.ssi_signo);
}

}  // namespace voidpath::daemon

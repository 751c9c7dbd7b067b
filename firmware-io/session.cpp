// The thread of one printer. It opens the port, moves bytes between port and driver, carries out what other
// threads posted, and reopens a port that went away. It never sleeps but in poll(), never waits on a lock
// beyond the short one of its mailbox, and no exception leaves it. Whoever owns the PrinterPort commands it.
#include "firmware-io/session.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <unistd.h>

namespace voidpath::fw {
namespace {

// The longest poll(); deadlines come back into view at least so often.
constexpr double kLongestPoll_s = 3600;
// The longest rest beside a readable port.
constexpr double kLongestRest_s = 0.02;
// So long a halt is repeated that ends a print with its session.
constexpr double kLastWords_s = 3;
// By so much the kernel may be late of its own accord, to wake several threads at once; it is 50 us if none
// is named, a sixth of the time by which a rest ends before the wire runs dry.
constexpr unsigned long kTimerSlack_ns = 1000;
// A shorter one costs more than it saves.
constexpr double kShortestRest_s = 0.0001;

class Session final : public PrinterPort {
 public:
  Session(SessionTiming timing, OpenTransport open, std::shared_ptr<const Clock> clock, Handler handler,
          const MakeDialogue& make)
      : timing_(timing),
        open_(std::move(open)),
        clock_(std::move(clock)),
        steady_(steady_clock()),
        dialogue_(make(*clock_, recorder_, std::move(handler))),
        wake_fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (wake_fd_ < 0) throw std::runtime_error("cannot create an eventfd");
    thread_ = std::thread([this] { run(); });
  }

  ~Session() override {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake();
    thread_.join();
    delete halt_.load();
    ::close(wake_fd_);
  }

  void print(std::unique_ptr<LineSource> source) override {
    auto shared = std::make_shared<std::unique_ptr<LineSource>>(std::move(source));
    post([this, shared] { dialogue_->print(std::move(*shared), now()); });
  }
  void pause() override {
    post([this] { dialogue_->pause(); });
  }
  void resume() override {
    post([this] { dialogue_->resume(now()); });
  }
  void cancel(std::string reason) override {
    post([this, reason = std::move(reason)] { dialogue_->cancel(reason, now()); });
  }
  void halt(std::string reason) override {
    // Past the mailbox: an emergency stop waits for nobody who posts.
    delete halt_.exchange(new std::string(std::move(reason)));
    wake();
  }
  void forget_halt() override {
    post([this] { halt_owed_.reset(); });
  }
  void command(std::string text) override {
    post([this, text = std::move(text)] { dialogue_->command(text, now()); });
  }
  std::vector<std::string> dialogue() const override { return recorder_.lines(); }

 private:
  double now() const noexcept { return steady_->now_s(); }

  void wake() noexcept {
    const std::uint64_t one = 1;
    // Fails only when the counter is full, that is when a wake-up is pending anyway.
    [[maybe_unused]] const auto n = ::write(wake_fd_, &one, sizeof one);
  }

  void post(std::function<void()> work) {
    {
      const std::lock_guard lock(mutex_);
      posted_.push_back(std::move(work));
    }
    wake();
  }

  // --- the session's thread ---

  void run() noexcept {
    ::prctl(PR_SET_TIMERSLACK, kTimerSlack_ns);
    double stop_at = 0;
    bool called = true;
    while (!called || !must_end(stop_at)) {
      if (!transport_ && stop_at == 0 && now() >= reopen_at_) reopen();
      called = wait_for_something(stop_at) || stop_at > 0;
      if (called) carry_out_posted();
      try {
        move_bytes();
      } catch (const PortError& error) {
        close_port(error.what());
      }
      if (transport_ && dialogue_->closing()) close_port({});
    }
  }

  // True when the thread may end. The first time it is asked to, a running print is brought to its end.
  bool must_end(double& stop_at) {
    {
      const std::lock_guard lock(mutex_);
      if (!stop_) return false;
    }
    if (stop_at == 0) {
      stop_at = now() + timing_.shutdown_s;
      dialogue_->shut_down(now());
      flush_quietly();
      due_ = dialogue_->deadline();
    }
    if (halt_.load() != nullptr) return false;
    if (!transport_ || dialogue_->finished()) return true;
    if (now() < stop_at) return false;
    if (std::exchange(last_words_, true) || dialogue_->cold()) return true;
    // Nobody is left to turn the heaters off.
    dialogue_->halt("the print did not end in time", now());
    flush_quietly();
    due_ = dialogue_->deadline();
    stop_at = now() + kLastWords_s;
    return false;
  }

  void reopen() {
    try {
      transport_ = open_();
      dialogue_->opened(now());
      if (halt_owed_) dialogue_->halt(*halt_owed_, now());
      due_ = dialogue_->deadline();
    } catch (const std::exception& error) {
      close_port(error.what());
    }
  }

  // An empty reason: the driver itself gave up and has said why.
  void close_port(const std::string& reason) {
    if (!reason.empty()) dialogue_->lost(reason);
    if (transport_ && dialogue_->halt_heard()) halt_owed_.reset();
    flush_quietly();
    transport_.reset();
    reopen_at_ = now() + timing_.reconnect_s;
  }

  // True when another thread wants something.
  bool wait_for_something(double stop_at) {
    std::array<pollfd, 2> fds{pollfd{wake_fd_, POLLIN, 0}, pollfd{-1, POLLIN, 0}};
    double until = reopen_at_;
    if (transport_) {
      fds[1].fd = transport_->fd();
      if (!dialogue_->output().empty()) fds[1].events |= POLLOUT;
      until = due_;
    }
    if (stop_at > 0) until = std::min(until, stop_at);
    if (transport_ && dialogue_->output().empty() && fds[1].events == POLLIN) {
      // With the port left out of it: only another thread's word ends this rest early.
      const double begin = now();
      const double end = std::min({dialogue_->unhurried_until(), until, begin + kLongestRest_s});
      if (end - begin > kShortestRest_s && wait(fds[0], 1, end - begin) == 0) {
        // What came meanwhile is read at once; the next wait finds out if it was nothing.
        dialogue_->rested(end, now());
        return false;
      }
    }
    wait(fds[0], fds.size(), std::clamp(until - now(), 0.0, kLongestPoll_s));
    if (fds[0].revents == 0) return false;
    std::uint64_t count = 0;
    [[maybe_unused]] const auto n = ::read(wake_fd_, &count, sizeof count);
    return true;
  }

  static int wait(pollfd& first, std::size_t count, double seconds) noexcept {
    const auto whole = static_cast<std::time_t>(seconds);
    const timespec time{whole, static_cast<long>((seconds - static_cast<double>(whole)) * 1e9)};
    return ::ppoll(&first, count, &time, nullptr);
  }

  void carry_out_posted() {
    if (const std::unique_ptr<const std::string> reason{halt_.exchange(nullptr)}) {
      halt_owed_ = *reason;
      if (transport_) dialogue_->halt(*reason, now());
    }
    std::vector<std::function<void()>> work;
    {
      const std::lock_guard lock(mutex_);
      work.swap(posted_);
    }
    for (const auto& task : work) task();
  }

  void move_bytes() {
    if (!transport_) return;
    flush();
    std::array<char, 4096> buffer;
    while (const std::size_t n = transport_->read(buffer)) {
      dialogue_->received({buffer.data(), n}, now());
      flush();
      if (n < buffer.size() || dialogue_->closing()) break;
    }
    due_ = dialogue_->deadline();
    if (now() < due_) return;
    dialogue_->elapsed(now());
    flush();
    due_ = dialogue_->deadline();
  }

  void flush() {
    if (dialogue_->take_urgent()) transport_->drop_output();
    std::string& output = dialogue_->output();
    if (!output.empty()) output.erase(0, transport_->write(output));
  }

  void flush_quietly() noexcept {
    try {
      if (transport_) flush();
    } catch (const PortError&) {
      // The port is being given up; there is nobody to tell.
    }
  }

  const SessionTiming timing_;
  const OpenTransport open_;
  const std::shared_ptr<const Clock> clock_;
  const std::shared_ptr<const Clock> steady_;
  FlightRecorder recorder_;                   // locks for itself
  const std::unique_ptr<Dialogue> dialogue_;  // the session's thread alone
  std::unique_ptr<Transport> transport_;
  double reopen_at_ = 0;
  double due_ = 0;  ///< the dialogue's deadline
  bool last_words_ = false;
  /// The reason of a halt that the printer has not answered to.
  std::optional<std::string> halt_owed_;

  std::atomic<std::string*> halt_{nullptr};  ///< the reason of a halt not yet carried out; owned

  std::mutex mutex_;  ///< guards posted_ and stop_
  std::vector<std::function<void()>> posted_;
  bool stop_ = false;

  const int wake_fd_;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<PrinterPort> start_session(SessionTiming timing, OpenTransport open,
                                           std::shared_ptr<const Clock> clock, PrinterPort::Handler handler,
                                           const MakeDialogue& make) {
  return std::make_unique<Session>(timing, std::move(open), std::move(clock), std::move(handler), make);
}

}  // namespace voidpath::fw

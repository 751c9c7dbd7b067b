// One thread for each emergency-stop switch: poll(), read the edge, cut, halt, report. It owns its pin, takes
// no lock before the report, and allocates nothing before power is cut.
#include "firmware-io/gpio/emergency_stop.h"

#include "firmware-io/clock.h"
#include "firmware-io/gpio/debounce.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <system_error>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace voidpath::fw {

EmergencyStop::EmergencyStop(std::unique_ptr<InputPin> pin, EmergencyStopOptions options,
                             EmergencyStopActions actions)
    : pin_(std::move(pin)), options_(options), actions_(std::move(actions)) {
  pulled_ = pin_->active();  // known before anyone asks
  end_fd_ = ::eventfd(0, EFD_CLOEXEC);
  if (end_fd_ < 0) throw std::system_error(errno, std::generic_category(), "emergency stop");
  thread_ = std::thread([this] { run(); });
}

EmergencyStop::~EmergencyStop() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(end_fd_, &one, sizeof one);
  thread_.join();
  ::close(end_fd_);
}

void EmergencyStop::stop(const std::string& reason) {
  pulled_ = true;  // first: who forgives cuts looks at them, then at this
  actions_.cut();
  actions_.halt();
  actions_.report(true, reason);
}

void EmergencyStop::tell(std::optional<bool> active) {
  if (!active) return;
  if (*active) return stop("the emergency stop was pulled");
  pulled_ = false;
  actions_.report(false, "the emergency stop was let go");
}

void EmergencyStop::run() noexcept {
  const auto clock = steady_clock();
  // An edge that lasts no time at all still counts where no time is asked for.
  const bool at_once = options_.debounce_s <= 0;
  Debounce contact(options_.debounce_s, pulled_);
  if (pulled_) stop("the emergency stop is pulled");
  for (;;) {
    const double now = clock->now_s();
    const double wait_s = std::clamp(contact.deadline() - now, 0.0, options_.look_s);
    std::array<pollfd, 2> fds{pollfd{pin_->fd(), POLLIN, 0}, pollfd{end_fd_, POLLIN, 0}};
    ::poll(fds.data(), fds.size(), static_cast<int>(std::ceil(wait_s * 1000)));
    if (fds[1].revents != 0) return;
    try {
      while (const auto edge = pin_->next_edge()) {
        tell(contact.settle(edge->at_s));  // what had lasted until then
        contact.edge(edge->active, edge->at_s);
        if (at_once) tell(contact.settle(edge->at_s));
      }
      const double then = clock->now_s();
      contact.level(pin_->active(), then);
      tell(contact.settle(then));
    } catch (const PinError& error) {
      stop(std::string("the emergency stop's pin failed: ") + error.what());
      return;  // a switch that cannot be read stays pulled
    }
  }
}

}  // namespace voidpath::fw

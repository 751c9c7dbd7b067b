#include "daemon/pins/contact.h"

#include <cmath>
#include <utility>

namespace voidpath::daemon {

Contact::Contact(Executor& loop, std::unique_ptr<fw::InputPin> pin, double quiet_s,
                 std::function<void()> changed)
    : loop_(loop), pin_(std::move(pin)), contact_(quiet_s, pin_->active()), changed_(std::move(changed)) {
  loop_.add_fd(pin_->fd(), [this] { read(); });
}

Contact::~Contact() {
  loop_.cancel(timer_);
  if (failure_.empty()) loop_.remove_fd(pin_->fd());
}

void Contact::settle(double now_s) {
  if (contact_.settle(now_s)) changed_();
}

void Contact::read() {
  loop_.cancel(timer_);
  try {
    while (const auto edge = pin_->next_edge()) {
      settle(edge->at_s);  // what had lasted until then, should the loop have been busy
      contact_.edge(edge->active, edge->at_s);
    }
    contact_.level(pin_->active(), loop_.now_s());
  } catch (const fw::PinError& error) {
    loop_.remove_fd(pin_->fd());
    failure_ = error.what();
    changed_();
    return;
  }
  settle(loop_.now_s());
  const double wait_s = contact_.deadline() - loop_.now_s();
  if (std::isfinite(wait_s)) timer_ = loop_.after(wait_s, [this] { read(); });
}

}  // namespace voidpath::daemon

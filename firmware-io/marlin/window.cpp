#include "firmware-io/marlin/window.h"

#include "firmware-io/marlin/codec.h"

#include <algorithm>
#include <cassert>

namespace voidpath::fw::marlin {
namespace {

// A typical framed move. Patience raises the limit by so much.
constexpr int kTypicalLine = 40;

// An error is followed by its Resend and that by its ok.
constexpr int kOkAfterError = 2;
constexpr int kOkAfterResend = 1;

int digits(std::uint32_t value) noexcept {
  int n = 1;
  while (value >= 10) value /= 10, ++n;
  return n;
}

}  // namespace

Window::Window(WindowOptions options)
    : options_(options),
      history_(options.history),
      limit_(options.max_bytes),
      threshold_(options.max_bytes) {}

void Window::restart(std::uint32_t last) {
  in_flight_.clear();
  first_kept_ = cursor_ = next_ = last + 1;
  acknowledged_ = last;
  bytes_in_flight_ = 0;
  limit_ = threshold_ = options_.max_bytes;
  draining_ = grant_ = probing_ = probe_answered_ = resent_was_in_flight_ = false;
  request_ok_due_ = 0;
  round_line_ = 0;
  rounds_ = impossible_ = stalls_ = 0;
  health_ = Health::good;
}

// N, digits, blank, payload, star, at most three digits, newline. The checksum is taken at its longest.
std::size_t Window::framed_bytes(std::string_view payload) const noexcept {
  return payload.size() + static_cast<std::size_t>(digits(next_)) + 7;
}

bool Window::has_room(std::size_t bytes) const noexcept {
  if (draining_ || health_ != Health::good) return false;
  if (grant_ || bytes_in_flight_ == 0) return true;
  return bytes_in_flight_ + static_cast<int>(bytes) <= limit_;
}

bool Window::may_send(std::string_view payload) const noexcept {
  return !resending() && has_room(framed_bytes(payload));
}

void Window::note_sent(std::uint32_t number, std::size_t bytes) {
  in_flight_.push_back({number, static_cast<int>(bytes)});
  bytes_in_flight_ += static_cast<int>(bytes);
  if (grant_) {
    grant_ = false;
    probing_ = true;
    probe_answered_ = false;
  }
}

std::string Window::send(std::string_view payload) {
  assert(may_send(payload));
  std::string framed = frame(next_, payload);
  assert(framed.size() <= kMaxFramed + 1);
  slot(next_) = payload;
  note_sent(next_, framed.size());
  cursor_ = ++next_;
  if (next_ - first_kept_ > history_.size())
    first_kept_ = next_ - static_cast<std::uint32_t>(history_.size());
  return framed;
}

std::optional<std::string> Window::resend() {
  if (!resending()) return {};
  std::string framed = frame(cursor_, slot(cursor_));
  if (!has_room(framed.size())) return {};
  note_sent(cursor_, framed.size());
  ++cursor_;
  return framed;
}

void Window::sent_unnumbered() { in_flight_.push_back({0, 0}); }

void Window::acknowledge_front() {
  const Flight front = in_flight_.front();
  in_flight_.pop_front();
  bytes_in_flight_ -= front.bytes;
  acknowledged_ = std::max(acknowledged_, front.number);
  limit_ = std::min(options_.max_bytes, limit_ + (limit_ < threshold_ ? std::max(front.bytes, 1) : 1));
}

void Window::acknowledge_all() {
  while (!in_flight_.empty()) acknowledge_front();
}

void Window::on_ok(std::optional<std::uint32_t> line) {
  if (request_ok_due_ > 0) {
    request_ok_due_ = 0;
    ++request_oks_seen_;
    return;
  }
  stalls_ = 0;
  probe_answered_ = true;
  if (line) {
    const auto known = std::find_if(in_flight_.begin(), in_flight_.end(),
                                    [&](const Flight& flight) { return flight.number == *line; });
    for (auto n = known == in_flight_.end() ? 0 : known - in_flight_.begin() + 1; n > 0; --n)
      acknowledge_front();
    return;  // a number not in flight is old, or damaged
  }
  if (!in_flight_.empty()) {
    acknowledge_front();
    return;
  }
  ++disturbances_;
  if (draining_ && resent_was_in_flight_ && resending()) {
    // Nothing else is owed: the line had been taken after all, and would now be met with silence. If this
    // guess is wrong the firmware asks again.
    resent_was_in_flight_ = false;
    acknowledged_ = std::max(acknowledged_, cursor_);
    ++cursor_;
  }
}

void Window::rewind_to(std::uint32_t line) {
  const bool again = rounds_ > 0 && line == round_line_ &&
                     std::any_of(in_flight_.begin(), in_flight_.end(),
                                 [&](const Flight& flight) { return flight.number == line; });
  resent_was_in_flight_ = again || (draining_ && resent_was_in_flight_ && line == cursor_);
  std::erase_if(in_flight_,
                [&](const Flight& flight) { return flight.number == 0 || flight.number >= line; });
  for (Flight& flight : in_flight_) flight.bytes = 0;  // taken, hence no longer in the ring
  bytes_in_flight_ = 0;
  cursor_ = line;
}

void Window::on_resend(std::uint32_t line) {
  ++resend_requests_;
  ++disturbances_;
  const bool says_ok = request_oks_missed_ <= request_oks_seen_;
  request_ok_due_ = says_ok ? kOkAfterResend : 0;
  if (line < first_kept_ || line > next_) {
    if (++impossible_ >= options_.stuck_rounds) give_up(Health::no_history);
    if (!draining_) rewind_to(cursor_);  // let it ask again, one line at a time
  } else {
    if (line <= acknowledged_ && !draining_) ++doubtful_requests_;
    rewind_to(line);
  }
  if (!draining_) threshold_ = std::max(limit_ / 2, 1);
  limit_ = 0;
  draining_ = true;
  grant_ = probing_ = false;
}

void Window::on_framing_error(std::optional<std::uint32_t> last_line) {
  ++disturbances_;
  if (last_line) {
    on_resend(*last_line + 1);
    --resend_requests_;  // the request itself follows and counts
  }
  request_ok_due_ = request_oks_missed_ <= request_oks_seen_ ? kOkAfterError : 0;
}

void Window::on_other_line() {
  if (request_ok_due_ > 0 && --request_ok_due_ == 0) ++request_oks_missed_;
}

void Window::on_quiet() {
  if (!draining_) return;
  draining_ = false;
  request_ok_due_ = 0;
  if (cursor_ == round_line_ && rounds_ > 0) {
    if (++rounds_ > options_.stuck_rounds) give_up(Health::stuck);
  } else {
    round_line_ = cursor_;
    rounds_ = 1;
    impossible_ = 0;
  }
}

void Window::on_patience() {
  if (!draining_) limit_ = std::min(options_.max_bytes, limit_ + kTypicalLine);
}

void Window::on_stall(bool may_overfill) {
  if (draining_) return;
  ++disturbances_;
  if (probing_ && probe_answered_) {
    // The probe's number follows those before it: had they not been taken, it would have been refused.
    acknowledge_all();
    probing_ = false;
    return;
  }
  if (!may_overfill && bytes_in_flight_ + kTypicalLine > options_.max_bytes) return;
  grant_ = true;
  if (++stalls_ > options_.silent_stalls) give_up(Health::silent);
}

}  // namespace voidpath::fw::marlin

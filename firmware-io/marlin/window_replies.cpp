#include "firmware-io/marlin/window.h"

#include <algorithm>
#include <utility>

/// What the printer's answers, and its silence, do to the window.
namespace voidpath::fw::marlin {
namespace {

// A typical framed move. Patience raises the limit by so much.
constexpr int kTypicalLine = 40;

// An error is followed by its Resend and that by its ok.
constexpr int kOkAfterError = 2;
constexpr int kOkAfterResend = 1;

// A request is early when the limit was still growing or had stood at the ceiling for fewer oks. With damage
// once in 10 kB every third is. So many in a row lower the ceiling by a quarter.
constexpr int kEarly_oks = 32;
constexpr int kEarlyRequestsThatTell = 4;

// Nobody asks for a line so long acknowledged but a firmware that has restarted unheard, or a damaged
// request.
constexpr std::uint32_t kDeepestRequest = 64;

// A request is two lines, the error with the last number and the number wanted. Damage to one of them may
// turn any number into the first; hardly to two in a row.
constexpr int kSignsOfRestart = 2;

// Work without an ok is probed so often as for a lost one; more stalls than that must be without any word.
constexpr int kStallsOfWork = 2;

// Marlin's BUFSIZE is 4, on big boards up to 64.
constexpr int kMostQueuePlaces = 64;

// So many oks for each byte that the ceiling comes back, at the slowest.
constexpr int kCreepSlowest_oks = 1024;

}  // namespace

void Window::acknowledge_front() {
  const Flight front = in_flight_.front();
  in_flight_.pop_front();
  bytes_in_flight_ -= front.bytes;
  acknowledged_ = std::max(acknowledged_, front.number);
  note_all_taken();
  grow(front.bytes);
}

// A request for a line tells that those before it were taken, and their oks may have come while it was not
// known what they were for: with nothing in flight and nothing to send again none is owed.
void Window::note_all_taken() noexcept {
  if (in_flight_.empty() && !resending()) acknowledged_ = next_ - 1;
}

// However low the ceiling, two lines may be out: else a lost ok would only be noticed by a stall.
int Window::patient_limit() const noexcept {
  return std::min(options_.max_bytes, std::max(ceiling_, 2 * kTypicalLine));
}

void Window::grow(int bytes) {
  if (limit_ < ceiling_) {
    limit_ = std::min(ceiling_, limit_ + (limit_ < threshold_ ? std::max(bytes, 1) : 1));
    oks_ = 0;
  } else if (++oks_ % creep_oks_ == 0 && ceiling_ < options_.max_bytes) {
    limit_ = ++ceiling_;
    if (ceiling_ == options_.max_bytes) creep_oks_ = kCreepFastest_oks;
  }
}

// A request came: one line next, and perhaps less than before in all.
void Window::restrain() {
  if (limit_ < ceiling_ || oks_ < kEarly_oks) {
    if (++early_requests_ >= kEarlyRequestsThatTell) lower_ceiling();
  } else {
    early_requests_ = 1;
    creep_oks_ = std::max(creep_oks_ / 2, kCreepFastest_oks);
  }
  oks_ = 0;
  threshold_ = std::max(limit_ / 2, 1);
}

void Window::lower_ceiling() {
  early_requests_ = 0;
  counts_trusted_ = false;
  ceiling_ = std::min(ceiling_, std::max(ceiling_ * 3 / 4, kTypicalLine));
  creep_oks_ = std::min(creep_oks_ * 4, kCreepSlowest_oks);
}

void Window::on_overrun() {
  if (!draining_) lower_ceiling();
  limit_ = std::min(limit_, ceiling_);
}

// The first so many lines in flight stand in the command queue.
void Window::leave_ring(int lines) {
  for (Flight& flight : in_flight_) {
    if (lines-- <= 0) return;
    bytes_in_flight_ -= std::exchange(flight.bytes, 0);
  }
}

void Window::acknowledge_all() {
  while (!in_flight_.empty()) acknowledge_front();
}

void Window::on_ok(std::optional<std::uint32_t> line, std::optional<int> queue_free, bool temperatures) {
  if (request_ok_due_ > 0) {
    request_ok_due_ = 0;
    ++request_oks_seen_;
    return;
  }
  stalls_ = 0;
  probe_answered_ = true;
  if (!line && queue_free && !in_flight_.empty() && in_flight_.front().number != 0) {
    // Of a line nobody sent: it acknowledges nothing.
    ++nameless_oks_;
    return;
  }
  if (temperatures) {
    const auto asked = std::find_if(in_flight_.begin(), in_flight_.end(),
                                    [](const Flight& flight) { return flight.question; });
    if (asked == in_flight_.end()) return;
    answered_ = first_taken_ = true;
    lost_oks_ += static_cast<std::uint64_t>(asked - in_flight_.begin());
    for (auto n = asked - in_flight_.begin() + 1; n > 0; --n) acknowledge_front();
    return;
  }
  if (line) {
    const auto known = std::find_if(in_flight_.begin(), in_flight_.end(),
                                    [&](const Flight& flight) { return flight.number == *line; });
    if (known == in_flight_.end()) return;  // old, or damaged
    for (auto n = known - in_flight_.begin() + 1; n > 0; --n) acknowledge_front();
    if (queue_free && *queue_free >= 0 && *queue_free <= kMostQueuePlaces) {
      queue_places_ = std::max(queue_places_, *queue_free);
      if (counts_trusted_ && !draining_) leave_ring(queue_places_ - *queue_free);
    }
    return;
  }
  if (!in_flight_.empty()) {
    acknowledge_front();
    return;
  }
  if (draining_ && resent_was_in_flight_ && resending() && cursor_ != cut_off_) {
    // Nothing else is owed: the line had been taken after all, and would now be met with silence. If this
    // guess is wrong the firmware asks again.
    resent_was_in_flight_ = false;
    acknowledged_ = std::max(acknowledged_, cursor_);
    ++cursor_;
  }
}

void Window::rewind_to(std::uint32_t line) {
  if (withheld_ > 0) cut_off_ = next_ - 1;
  if (cut_off_ != 0) line = std::min(line, cut_off_);  // whatever is asked for: nobody can have taken it
  const bool again = rounds_ > 0 && line == round_line_ &&
                     std::any_of(in_flight_.begin(), in_flight_.end(),
                                 [&](const Flight& flight) { return flight.number == line; });
  resent_was_in_flight_ = again || (draining_ && resent_was_in_flight_ && line == cursor_);
  std::erase_if(in_flight_,
                [&](const Flight& flight) { return flight.number == 0 || flight.number >= line; });
  for (Flight& flight : in_flight_) flight.bytes = 0;  // taken, hence no longer in the ring
  bytes_in_flight_ = withheld_ = 0;
  cursor_ = line;
  note_all_taken();
}

bool Window::wants_the_beginning(std::uint32_t line) {
  if (line != first_ || !first_taken_) {
    restart_signs_ = 0;
    return false;
  }
  if (++restart_signs_ >= kSignsOfRestart) give_up(Health::restarted);
  return true;
}

void Window::on_resend(std::uint32_t line) {
  ++resend_requests_;
  const bool says_ok = request_oks_missed_ <= request_oks_seen_;
  request_ok_due_ = says_ok ? kOkAfterResend : 0;
  if (wants_the_beginning(line)) {
    if (!draining_) rewind_to(cursor_);
  } else if (line < first_kept_ || line > next_ || line + kDeepestRequest < acknowledged_) {
    if (++impossible_ >= options_.stuck_rounds) give_up(Health::no_history);
    if (!draining_) rewind_to(cursor_);  // let it ask again, one line at a time
  } else {
    if (line <= acknowledged_ && !draining_) ++doubtful_requests_;
    rewind_to(line);
  }
  if (!draining_) restrain();
  limit_ = 0;
  draining_ = true;
  grant_ = probing_ = false;
}

void Window::on_framing_error(std::optional<std::uint32_t> last_line) {
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
  if (draining_) return;
  if (answers_missing()) return acknowledge_all();
  limit_ = std::max(limit_, std::min(patient_limit(), std::max(limit_, bytes_in_flight_) + kTypicalLine));
}

void Window::on_life() noexcept { stalls_ = std::min(stalls_, kStallsOfWork); }

void Window::on_stall(bool may_overfill, bool may_probe) {
  if (draining_) return;
  if (probing_ && probe_answered_) {
    // The probe's number follows those before it: had they not been taken, it would have been refused.
    acknowledge_all();
    probing_ = false;
    return;
  }
  grant_ = may_probe && (may_overfill || bytes_in_flight_ + kTypicalLine <= options_.max_bytes);
  if (++stalls_ > options_.silent_stalls) give_up(Health::silent);
}

}  // namespace voidpath::fw::marlin

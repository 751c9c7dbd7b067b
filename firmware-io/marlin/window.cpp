#include "firmware-io/marlin/window.h"

#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/meatpack.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace voidpath::fw::marlin {
namespace {

// A line is not begun for less.
constexpr int kShortestPiece = 4;
// Bytes of any line, packed or not; of an M105.
constexpr int kShortestFrame = 4;
constexpr int kLongestQuestion = 32;

// Of the lines in flight so many have left the receive buffer once all have arrived: BUFSIZE is 4, less what
// the panel may have put into the queue.
constexpr int kSurelyQueued = 2;

}  // namespace

Window::Window(WindowOptions options)
    : options_(options),
      history_(options.history),
      limit_(options.max_bytes),
      threshold_(options.max_bytes),
      ceiling_(options.max_bytes) {}

void Window::restart(std::uint32_t last) {
  in_flight_.clear();
  first_ = first_kept_ = cursor_ = next_ = last + 1;
  cut_off_ = 0;
  acknowledged_ = last;
  bytes_in_flight_ = withheld_ = 0;
  limit_ = threshold_ = ceiling_ = options_.max_bytes;
  creep_oks_ = kCreepFastest_oks;
  oks_ = early_requests_ = queue_places_ = 0;
  counts_trusted_ = true;
  draining_ = grant_ = probing_ = probe_answered_ = resent_was_in_flight_ = false;
  question_ = answered_ = first_taken_ = false;
  request_ok_due_ = 0;
  round_line_ = 0;
  rounds_ = impossible_ = stalls_ = restart_signs_ = 0;
  health_ = Health::good;
}

bool Window::has_room(int bytes) const noexcept {
  if (draining_ || withheld_ > 0 || health_ != Health::good) return false;
  if (grant_ || question_ || bytes_in_flight_ == 0) return true;
  return bytes_in_flight_ + bytes <= limit_;
}

const std::string& Window::encode(std::uint32_t number, std::string_view payload) const {
  framed_.clear();
  if (packing_) {
    unpacked_.clear();
    append_dense_frame(unpacked_, number, payload);
    append_packed(framed_, unpacked_);
  } else if (dense_) {
    append_dense_frame(framed_, number, payload);
  } else {
    append_frame(framed_, number, payload);
  }
  return framed_;
}

// This is asked again and again while there is none: then nothing is framed for it.
bool Window::has_room_for(std::string_view payload) const {
  return has_room(kShortestFrame) && has_room(static_cast<int>(encode(next_, payload).size()));
}

bool Window::may_send(std::string_view payload) const {
  return !resending() && withheld_ == 0 && has_room_for(payload);
}

bool Window::may_begin(std::string_view payload) const {
  const bool in_pieces = piecewise_ && !packing_ && withheld_ == 0 && !draining_ && !resending() &&
                         !throttled() && health_ == Health::good &&
                         bytes_in_flight_ + kShortestPiece <= limit_;
  return in_pieces || may_send(payload);
}

void Window::note_sent(std::uint32_t number, std::size_t bytes) {
  in_flight_.push_back({number, static_cast<int>(bytes), kept(number) == "M105"});
  if (number == cut_off_) cut_off_ = 0;
  bytes_in_flight_ += static_cast<int>(bytes);
  question_ = answered_ = false;
  if (grant_) use_grant();
}

void Window::use_grant() noexcept {
  grant_ = false;
  probing_ = true;
  probe_answered_ = false;
}

const std::string& Window::send(std::string_view payload) {
  const std::string& framed = encode(next_, payload);
  assert(!resending() && payload.size() <= kMaxPayload);
  const bool whole = has_room(static_cast<int>(framed.size()));
  assert(whole || (piecewise_ && bytes_in_flight_ < limit_));
  slot(next_) = payload;
  note_sent(next_, framed.size());
  if (!whole) withheld_ = bytes_in_flight_ - limit_;
  cursor_ = ++next_;
  if (next_ - first_kept_ > history_.size())
    first_kept_ = next_ - static_cast<std::uint32_t>(history_.size());
  return framed;
}

int Window::let_out() {
  const bool alone = in_flight_.size() <= 1;
  int out = std::clamp(limit_ - (bytes_in_flight_ - withheld_), 0, withheld_);
  if (out < withheld_ && (alone || grant_)) {
    out = withheld_;
    if (!alone) use_grant();
  }
  withheld_ -= out;
  return out;
}

std::optional<std::string> Window::resend() {
  if (!resending()) return {};
  const std::string& framed = encode(cursor_, slot(cursor_));
  if (!has_room(static_cast<int>(framed.size()))) return {};
  note_sent(cursor_, framed.size());
  ++cursor_;
  return framed;
}

bool Window::may_ask(std::string_view question) const {
  if (draining_ || resending() || health_ != Health::good) return false;
  int bytes = bytes_in_flight_;
  for (std::size_t i = 0; i < in_flight_.size() && i < kSurelyQueued; ++i) bytes -= in_flight_[i].bytes;
  if (bytes + kLongestQuestion <= options_.max_bytes) return true;
  return bytes + static_cast<int>(encode(next_, question).size()) <= options_.max_bytes;
}

int Window::questions() const {
  return static_cast<int>(std::count_if(in_flight_.begin(), in_flight_.end(),
                                        [](const Flight& flight) { return flight.question; }));
}

bool Window::answers_missing() const {
  return answered_ && !resending() && !in_flight_.empty() &&
         std::all_of(in_flight_.begin(), in_flight_.end(),
                     [](const Flight& flight) { return flight.question; });
}

void Window::sent_unnumbered() { in_flight_.push_back({}); }

}  // namespace voidpath::fw::marlin

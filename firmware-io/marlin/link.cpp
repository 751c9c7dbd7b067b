#include "firmware-io/marlin/link.h"

#include "firmware-io/marlin/codec.h"
#include "firmware-io/marlin/meatpack.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace voidpath::fw::marlin {
namespace {

/// What an ok may seem to come before its line has gone, by clocks and buffers alone, s.
constexpr double kClocksAgree_s = 0.0005;
/// A byte's time on the fastest wire that goes by a name, as a part of the named one.
constexpr double kFastest = 0.95;
constexpr double kNever = std::numeric_limits<double>::infinity();

// All that a request can have on its way behind it is there after so many times the quiet that ends it.
constexpr double kLongestDrain = 4;

// One `wait` may have crossed a line on its way; the second, a second later, cannot have.
constexpr int kWaitsThatMeanLoss = 2;

// Packing begins again after so many lines without a request.
constexpr std::uint64_t kQuietLines = 2000;

const std::string_view kQuestion = "M105";
// Garbage is common where the wire is bad or the firmware talkative.
constexpr double kBetweenQuestions_s = 1;
// Where a silence was mere work, the next question waits twice as long, up to this. It comes back by half
// with each so many oks: a heating in between says nothing of the moves behind it.
constexpr double kLongestPatience_s = 8;
constexpr int kOksToForget = 64;
// An answer may be lost as well, and so may the ok of a long command; but a firmware that says `busy`
// meanwhile, every 2 s, is at work.
constexpr double kAskAgain = 10;
constexpr int kMostQuestions = 2;

// A bare ok may be one of so many too many; the next is then not the long line's own either.
constexpr int kOksThatMeanDone = 16;

std::string without_colons(std::string_view payload) {
  std::string bare(payload);
  std::replace(bare.begin(), bare.end(), ':', '.');
  return bare;
}

}  // namespace

Link::Link(WindowOptions options, Timing timing, double byte_s, const Clock& stamp, FlightRecorder& recorder)
    : window_(options),
      timing_(timing),
      byte_s_(byte_s),
      stamp_(stamp),
      recorder_(recorder),
      ask_after_s_(timing.patience_s) {}

void Link::restart(std::uint32_t last) {
  window_.restart(last);
  outstanding_.clear();
  tail_.clear();
  long_number_ = unfinished_ = 0;
  end_due_ = false;
  questions_open_ = ends_unanswered_ = words_out_ = 0;
  end_heard_t_ = 0;
  wire_free_t_ = earliest_free_t_ = 0;
  wire_is_faster_ = wire_is_brake_ = false;
  pace_ = 1;
  awaited_ = rested_for_ = 0;
  held_ = question_due_ = doubt_ = asked_in_silence_ = unpacks_perhaps_ = false;
  questions_ = 0;
  waits_ = 0;
}

// Plain lines again, whatever state lost or flushed bytes have left the firmware's unpacker in.
void Link::stop_packing() {
  if (!packed_once_) return;
  output_ += kPackingOff;
  unpacks_perhaps_ = true;
  window_.set_packing(false);
  quiet_lines_ = 0;
}

bool Link::packing_due() const noexcept {
  return packed_once_ && !window_.packing() && quiet_lines_ >= kQuietLines && !window_.draining() &&
         !window_.resending();
}

void Link::drop_output() {
  output_.clear();
  tail_.clear();
  window_.end_line();
}

void Link::put(std::string_view bytes, double t) {
  patience_t_ = silent_since_t_ = t;
  question_due_ = false;
  output_ += bytes;
  const double wire_s = static_cast<double>(bytes.size()) * byte_s_;
  wire_free_t_ = std::max(wire_free_t_, t) + pace_ * wire_s;
  earliest_free_t_ = std::max(earliest_free_t_, t) + kFastest * wire_s;
  bytes_sent_ += bytes.size();
}

void Link::write(std::string_view bytes, std::string_view shown, double t) {
  if (window_.bytes_in_flight() <= static_cast<int>(bytes.size())) progress_t_ = t;  // nothing else was out
  recorder_.sent(stamp_.now_s(), shown);
  put(bytes, t);
  ++lines_sent_;
}

void Link::let_out(std::size_t bytes, double t) {
  if (bytes == 0) return;
  put(std::string_view(tail_).substr(0, bytes), t);
  tail_.erase(0, bytes);
  if (tail_.empty() && !outstanding_.empty() && outstanding_.back().number + 1 == window_.next_number())
    note_gone(outstanding_.back());
}

// Beyond the limit, where something must follow.
void Link::end_line(double t) {
  window_.end_line();
  let_out(tail_.size(), t);
}

// What is out of it is refused for want of a checksum, or empty after a flush, but never joined to another.
void Link::break_line() {
  if (tail_.empty()) return;
  tail_.clear();
  window_.end_line();
  output_ += '\n';
}

// Another text has another checksum, which may be longer.
bool Link::may_send(std::string_view payload) const {
  if (unfinished_ > 0 && payload != kQuestion) return false;
  return loses_colons(payload) ? window_.may_send(without_colons(payload)) : window_.may_send(payload);
}

void Link::send(std::string_view payload, Tag tag, double t) {
  if (loses_colons(payload)) return send(without_colons(payload), tag, t);
  const std::uint32_t number = window_.next_number();
  outstanding_.push_back({number, tag});
  if (tag.is_long) long_number_ = number, oks_past_long_ = 0;
  if (tag.is_long && ok_at_enqueue_) unfinished_ = number, end_due_ = true, ends_asked_ = 0;
  if (payload == kQuestion) ++questions_open_;
  const std::string_view bytes = window_.send(payload);
  tail_ = bytes.substr(bytes.size() - static_cast<std::size_t>(window_.withheld()));
  write(bytes.substr(0, bytes.size() - tail_.size()), window_.text(), t);
  outstanding_.back().gone_t = kNever;
  if (tail_.empty()) note_gone(outstanding_.back());
}

void Link::send_raw(std::string_view text, bool answered, double t) {
  if (text.starts_with('\n'))
    break_line();
  else
    end_line(t);
  if (answered) window_.sent_unnumbered(), ++words_out_;
  // Plain text: the firmware's emergency parser looks at the bytes before they are unpacked.
  if (packed_once_) output_ += kPackingOff;
  const std::string line = std::string(text) + "\n";
  write(line, line, t);
  if (window_.packing()) output_ += kPackingOn;
}

void Link::pump(double t) {
  if (!tail_.empty()) let_out(static_cast<std::size_t>(window_.let_out()), t);
  while (const auto bytes = window_.resend()) write(*bytes, window_.text(), t);
}

void Link::on_reply(const Reply& reply, double t) {
  received_t_ = t;
  const bool was_draining = window_.draining();
  if (!std::holds_alternative<Wait>(reply)) waits_ = 0;
  if (const auto* ok = std::get_if<Ok>(&reply)) {
    const std::uint64_t lost = window_.lost_oks();
    window_.on_ok(ok->line, ok->queue_free, !ok->sensors.empty());
    note_ok(!ok->sensors.empty(), window_.lost_oks() - lost, t);
    note_length_done(*ok);
  } else if (const auto* resend = std::get_if<Resend>(&reply)) {
    window_.on_resend(resend->line);
    note_progress(t);
  } else if (const auto* error = std::get_if<Error>(&reply); error && error->kind == Error::Kind::framing) {
    window_.on_framing_error(error->last_line);
  } else if (std::holds_alternative<Wait>(reply)) {
    window_.on_other_line();
    note_nothing_queued(t);
    if (++waits_ >= kWaitsThatMeanLoss && window_.waiting()) {
      waits_ = 0;
      window_.on_stall();
      note_progress(t);
    }
  } else {
    if (std::holds_alternative<Overrun>(reply)) window_.on_overrun();
    if (const auto* state = std::get_if<PackState>(&reply); state && !state->on) unpacks_perhaps_ = false;
    // Temperatures, remarks: whoever says them is at work.
    if (may_be_at_length()) window_.on_life();
    doubt_ = doubt_ || (std::holds_alternative<Other>(reply) && window_.waiting());
    window_.on_other_line();
  }
  if (window_.draining() && !was_draining) {
    drain_t_ = t;
    break_line();
    stop_packing();
  }
}

void Link::on_answer_apart(double t) {
  if (!window_.asking() || window_.draining() || long_outstanding()) return;
  const std::uint64_t lost = window_.lost_oks();
  window_.on_ok({}, {}, true);
  note_ok(true, window_.lost_oks() - lost, t);
}

void Link::note_ok(bool temperatures, std::uint64_t lost, double t) {
  note_progress(t);
  patience_t_ = silent_since_t_ = t;
  question_due_ = false;
  questions_ = words_out_ = 0;
  if (++oks_since_ % kOksToForget == 0) ask_after_s_ = std::max(ask_after_s_ / 2, timing_.patience_s);
  if (!temperatures) return;
  questions_open_ = std::max(questions_open_ - 1, 0);
  doubt_ = false;
  if (lost > 0) {
    ask_after_s_ = timing_.patience_s;
  } else if (asked_in_silence_) {
    ask_after_s_ = std::min(ask_after_s_ * 2, kLongestPatience_s);
    oks_since_ = 0;
  }
  asked_in_silence_ = false;
}

// Acknowledged is not done: an ok that came twice may have stood for the long line.
void Link::note_length_done(const Ok& ok) noexcept {
  if (long_number_ == 0 || window_.acknowledged() < long_number_) return;
  const bool sure = !ok.sensors.empty() || (ok.line && *ok.line >= long_number_);
  if (sure || ++oks_past_long_ >= kOksThatMeanDone) long_number_ = 0;
}

double Link::ask_at() const {
  if (window_.draining() || !window_.waiting() || held_ || !window_.may_ask(kQuestion)) return kNever;
  const bool is_long = long_outstanding();
  if (questions_ >= (is_long ? 1 : kMostQuestions)) return kNever;
  const double arrived_s = round_trip_s_ + 128 * byte_s_;
  return silent_since_t_ + arrived_s +
         (is_long || window_.asking() ? kAskAgain * timing_.patience_s : ask_after_s_);
}

bool Link::wants_question() const {
  if (question_due_ && window_.may_ask(kQuestion)) return true;
  return doubt_ && !window_.asking() && !window_.draining() && window_.waiting() &&
         received_t_ >= asked_t_ + kBetweenQuestions_s && window_.may_send(kQuestion);
}

void Link::ask(double t) {
  if (std::exchange(question_due_, false)) {
    asked_in_silence_ = true;
    window_.allow_question();
  }
  doubt_ = false;
  asked_t_ = t;
  end_line(t);
  send(kQuestion, {}, t);
}

std::optional<Tag> Link::take_acknowledged() {
  if (outstanding_.empty() || outstanding_.front().number > window_.acknowledged()) return {};
  if (unfinished_ > 0 && outstanding_.front().number >= unfinished_) return {};
  const Tag tag = outstanding_.front().tag;
  const Outstanding& line = outstanding_.front();
  if (std::isfinite(line.gone_t)) {
    if (received_t_ + kClocksAgree_s < line.earliest_gone_t) wire_is_faster_ = true;
    note_ok_time(line);
  }
  ++quiet_lines_;
  outstanding_.pop_front();
  return tag;
}

double Link::quiet_after_s() const noexcept {
  // What was on the wire both ways when the request was made, at its longest.
  const double wire_s = 2 * 128 * byte_s_;
  return timing_.quiet_s + 2 * round_trip_s_ + wire_s;
}

// Who is still not quiet then talks of something else, or asks again by himself as Repetier does.
double Link::drained_at() const noexcept {
  return std::min(received_t_ + quiet_after_s(), drain_t_ + kLongestDrain * quiet_after_s());
}

bool Link::long_outstanding() const noexcept {
  return std::any_of(outstanding_.begin(), outstanding_.end(),
                     [](const Outstanding& line) { return line.tag.is_long; });
}

double Link::stall_after_s() const noexcept {
  if (window_.probe_was_answered()) return timing_.probe_s;
  // A long command is probed once, in case its ok was lost, and then left alone.
  if (!busy_seen_ && window_.stalls() > 0 && may_be_at_length()) return timing_.long_silence_s;
  return busy_seen_ ? timing_.busy_silence_s : timing_.silence_s;
}

double Link::deadline() const {
  if (window_.draining()) return drained_at();
  if (stranded()) return patience_t_ + timing_.patience_s;
  if (!window_.waiting() || held_) return ask_end_at();
  double next = std::min({progress_t_ + stall_after_s(), ask_at(), ask_end_at()});
  if (window_.throttled() || window_.answers_missing())
    next = std::min(next, patience_t_ + timing_.patience_s);
  return next;
}

void Link::elapsed(double t) {
  if (window_.draining()) {
    if (t < drained_at()) return;
    window_.on_quiet();
    note_progress(t);
    if (unpacks_perhaps_) stop_packing();
    return;
  }
  if (stranded() && t >= patience_t_ + timing_.patience_s) question_due_ = true, patience_t_ = t;
  if (t >= ask_end_at()) end_unanswered(t);
  if (!window_.waiting() || held_) return;
  const bool impatient = window_.throttled() || window_.answers_missing();
  if (impatient && t >= patience_t_ + timing_.patience_s) window_.on_patience(), patience_t_ = t;
  if (t >= ask_at()) {
    question_due_ = true;
    ++questions_;
    silent_since_t_ = t;
  }
  if (t >= progress_t_ + stall_after_s()) {
    // What stands in the command queue of a firmware at work keeps out what is urgent.
    const bool at_length = may_be_at_length();
    const bool may_probe = !at_length || window_.questions() + words_out_ < kMostQuestions ||
                           t >= asked_t_ + timing_.ask_again_s;
    window_.on_stall(!at_length || window_.may_ask(kQuestion), may_probe);
    if ((window_.stalls() > 1 || unpacks_perhaps_) && tail_.empty()) stop_packing();
    progress_t_ = t;
  }
}

}  // namespace voidpath::fw::marlin

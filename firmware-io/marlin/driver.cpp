#include "firmware-io/marlin/driver.h"

#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace voidpath::fw::marlin {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kStatsPeriod_s = 10;

// Temperature polling where the firmware does not report by itself, as fast as people can use it.
constexpr double kPollHot_s = 2;
constexpr double kPollCold_s = 5;
// A firmware that reports each second and has been mute for so long is asked whether it lives.
constexpr double kMute_s = 10;

// After the printer has said that it halts the port stays open so long, for its last words.
constexpr double kLastWords_s = 1;

// An ok that has begun to come is there after so long: not each of its bytes is worth an awakening.
constexpr double kRestOfOk_bytes = 4;

// A silence of so many intervals is none of work.
constexpr double kKeepalives = 3;

Timing at_pace(Timing timing, int keepalive_s) {
  timing.busy_silence_s = std::max(timing.busy_silence_s, kKeepalives * keepalive_s);
  timing.ask_again_s = std::max(timing.ask_again_s, kKeepalives * keepalive_s);
  return timing;
}

}  // namespace

Driver::Driver(DriverOptions options, const Clock& stamp, FlightRecorder& recorder,
               std::function<void(const Event&)> handler)
    : options_(std::move(options)),
      stamp_(stamp),
      recorder_(recorder),
      handler_(std::move(handler)),
      link_(options_.window, at_pace(options_.timing, options_.keepalive_s), options_.byte_s, stamp_,
            recorder) {}

void Driver::emit(decltype(Event::what) what) { handler_({stamp_.now_s(), std::move(what)}); }

void Driver::received(std::string_view bytes, double t) {
  stamp_.look();
  received_t_ = t;
  splitter_.feed(bytes);
  std::string line;
  while (phase_ != Phase::closed && splitter_.next(line)) dispatch(line, t);
  settle(t);
}

// After anything that may have changed what can be sent.
void Driver::settle(double t) {
  if (phase_ == Phase::identifying || phase_ == Phase::ready) {
    collect(t);
    pump(t);
    check_health(t);
    rest_until_ = job_ && phase_ == Phase::ready ? link_.rest_until() : 0;
    if (job_ && rest_until_ == 0 && splitter_.amid_line())
      rest_until_ = t + kRestOfOk_bytes * options_.byte_s;
  }
}

void Driver::dispatch(const std::string& line, double t) {
  recorder_.received(stamp_.now_s(), line);
  const Reply reply = parse_reply(line);
  if (phase_ == Phase::identifying || phase_ == Phase::ready) link_.on_reply(reply, t);
  // Klipper says its name behind its ok.
  if (phase_ == Phase::identifying && std::holds_alternative<Ok>(reply) &&
      line.find("FIRMWARE_NAME:") != std::string::npos)
    dispatch_handshake(parse_reply(line.substr(line.find("FIRMWARE_NAME:"))), t);
  if (phase_ == Phase::identifying || queries_unanswered_ > 0) settings_.take(line);
  if (phase_ == Phase::ready) {
    dispatch_ready(reply, t);
  } else if (phase_ == Phase::halted) {
    emit(Message{line});
    const auto* error = std::get_if<Error>(&reply);
    if ((error != nullptr && error->kind == Error::Kind::fatal) || std::holds_alternative<Start>(reply)) {
      halt_heard_ = true;
      halting_until_ = t;
      enter(Phase::halted, t + kLastWords_s);
    }
  } else {
    dispatch_handshake(reply, t);
  }
}

void Driver::collect(double t) {
  while (const auto tag = link_.take_acknowledged()) {
    if (tag->kind == Tag::Kind::query) {
      if (--queries_unanswered_ == 0) tell_limits();
    } else if (tag->kind == Tag::Kind::resume) {
      if (std::exchange(unparking_, false)) go_on(t);
    } else if (job_ && tag->kind != Tag::Kind::control) {
      job_->on_acknowledged(*tag);
      drop_finished_job();
    }
  }
  if (phase_ == Phase::identifying && link_.all_acknowledged()) {
    if (!firmware_.name.empty()) {
      ask_packing(t);
    } else {
      phase_deadline_ = std::min(phase_deadline_, t + options_.handshake.nameless_s);
    }
  }
}

void Driver::pump(double t) {
  link_.pump(t);
  if (link_.wants_question()) link_.ask(t);
  if (packing_again(t)) return;
  while (!queries_.empty() && link_.may_send(queries_.front())) {
    link_.send(queries_.front(), {.kind = Tag::Kind::query}, t);
    queries_.pop_front();
  }
  // They would stand in the firmware's queue, where what is urgent needs the room.
  const auto held_back = [this] { return !controls_.empty() && link_.waits_at_length() && !unparking_; };
  while (!controls_.empty() && !held_back() && link_.may_send(controls_.front())) {
    const std::string line = std::move(controls_.front());
    controls_.pop_front();
    if (sets_keepalive(line)) link_.forget_busy();
    if (sets_reports(line) && offers("AUTOREPORT_TEMP")) autoreport_ = !ends_reports(line);
    const Tag::Kind kind = parked_ && line == parked_->resume ? Tag::Kind::resume : Tag::Kind::control;
    link_.send(line, {.kind = kind, .is_long = is_long(line)}, t);
  }
  if (job_ && queries_unanswered_ == 0 && (!held_back() || job_->ending())) job_->feed(link_, t);
  drop_finished_job();
  if (link_.wants_end()) link_.ask_end(t);
  if (link_.wants_probe() && link_.may_send("M105")) link_.ask(t);
}

void Driver::check_health(double t) {
  const std::uint64_t doubtful = link_.window().doubtful_requests();
  if (std::exchange(doubtful_seen_, doubtful) != doubtful) {
    emit(Message{"a line was wanted again after its ok: it may have run twice, or damaged"});
  }
  const std::uint64_t nameless = link_.window().nameless_oks();
  if (std::exchange(nameless_seen_, nameless) != nameless) {
    emit(Message{"the printer obeyed a line without a number: damage that it could not see"});
  }
  switch (link_.window().health()) {
    case Window::Health::good:
      return;
    case Window::Health::stuck:
      give_up("the printer refuses one line again and again", t);
      break;
    case Window::Health::no_history:
      give_up("the printer asks for a line that was never sent or is long gone", t);
      break;
    case Window::Health::silent:
      give_up("the printer no longer answers", t);
      break;
    case Window::Health::restarted:
      on_restart(t);
      break;
  }
}

// The dialogue cannot go on: what may still be heard is M112.
void Driver::give_up(const std::string& reason, double t) {
  if (job_)
    halt(reason, t);
  else
    disconnect(reason);
}

void Driver::disconnect(const std::string& reason) {
  phase_ = Phase::closed;
  forget_dialogue();
  if (std::exchange(connected_, false) || reason != last_loss_) emit(Disconnected{reason});
  last_loss_ = reason;
}

void Driver::lost(const std::string& reason) {
  stamp_.look();
  link_.drop_output();
  if (job_) {
    report_stats();
    job_.reset();
    emit(PrintFailed{"connection lost: " + reason});
  }
  disconnect(reason);
}

void Driver::elapsed(double t) {
  stamp_.look();
  if (phase_ == Phase::closed) return;
  if (phase_ != Phase::ready && t >= phase_deadline_) handshake_elapsed(t);
  if (phase_ == Phase::identifying || phase_ == Phase::ready) {
    link_.elapsed(t);
    if (phase_ == Phase::ready && t >= poll_at()) poll_temperature(t);
    if (repacking_until_ > 0 && t >= repacking_until_) packing_unanswered();
    if (t >= end_probe_at()) {
      end_probed_ = true;
      if (link_.may_send("M105")) link_.send("M105", {}, t);
    }
    if (job_ && t >= stats_t_ + kStatsPeriod_s) stats_t_ = t, report_stats();
  }
  settle(t);
}

double Driver::deadline() const noexcept {
  if (phase_ == Phase::closed) return kNever;
  double next = phase_ == Phase::ready ? poll_at() : phase_deadline_;
  if (phase_ == Phase::identifying || phase_ == Phase::ready) next = std::min(next, link_.deadline());
  if (job_) next = std::min(next, stats_t_ + kStatsPeriod_s);
  if (job_ && repacking_until_ == 0) next = std::min(next, job_->deadline(link_));
  if (repacking_until_ > 0) next = std::min(next, repacking_until_);
  next = std::min(next, end_probe_at());
  return next;
}

// At the end of a file nothing follows that would bring a lost ok to light; one question soon does.
double Driver::end_probe_at() const noexcept {
  if (!job_ || !job_->at_end() || end_probed_ || phase_ != Phase::ready || link_.window().draining())
    return kNever;
  return link_.progress_t() + options_.timing.patience_s / 2;
}

bool Driver::reports_by_itself() const noexcept { return autoreport_; }

bool Driver::offers(const std::string& capability) const {
  const auto found = firmware_.capabilities.find(capability);
  return found != firmware_.capabilities.end() && found->second;
}

double Driver::poll_at() const noexcept {
  // Its answer would come only after the wait, and it keeps what is urgent out of the firmware's queue.
  if (link_.waits_at_length() || (panel_waits_ && !link_.all_acknowledged())) return kNever;
  if (!reports_by_itself()) return polled_t_ + (hot_ ? kPollHot_s : kPollCold_s);
  // While lines are out the stall timers watch.
  return link_.all_acknowledged() ? std::max(received_t_, polled_t_) + kMute_s : kNever;
}

void Driver::poll_temperature(double t) {
  polled_t_ = t;
  if (controls_.empty() && !link_.window().asking()) controls_.push_back("M105");
}

}  // namespace voidpath::fw::marlin

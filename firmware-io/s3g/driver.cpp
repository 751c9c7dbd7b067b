#include "firmware-io/s3g/driver.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace voidpath::fw::s3g {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kStatsPeriod_s = 10;
/// The firmware ignores the toggle while it is pausing or going on.
constexpr double kToggleAgain_s = 2;
/// Between looks at a full queue, s; rarer when it stays full.
constexpr double kRoomPoll_s = 0.01;
constexpr double kRoomPollSlow_s = 0.1;
constexpr int kEagerRoomPolls = 20;
/// A dwell takes 72 minutes at the most, heating 30.
constexpr double kLongestCommand_s = 2 * 3600;
/// With so much room it is the wire that is narrow: then nothing is asked and packets are simply sent.
constexpr std::uint32_t kPlenty = kQueueBytes / 2;

constexpr char kBusy[] = "the printer is busy with a print from its own card or a script of its own";

}  // namespace

Driver::Driver(DriverOptions options, const Clock& stamp, FlightRecorder& recorder,
               std::function<void(const Event&)> handler)
    : options_(std::move(options)),
      stamp_(stamp),
      handler_(std::move(handler)),
      link_(options_.timing, stamp, recorder),
      encoder_(options_.machine) {}

void Driver::emit(decltype(Event::what) what) { handler_({stamp_.now_s(), std::move(what)}); }

void Driver::received(std::string_view bytes, double t) {
  last_t_ = t;
  if (phase_ == Phase::closed) return;
  link_.received(bytes, t);
  settle(t);
}

void Driver::elapsed(double t) {
  last_t_ = t;
  if (phase_ == Phase::closed) return;
  link_.elapsed(t);
  if (job_ && t >= stats_t_ + kStatsPeriod_s) {
    stats_t_ = t;
    report_stats();
  }
  settle(t);
}

double Driver::deadline() const noexcept {
  switch (phase_) {
    case Phase::closed:
      return kNever;
    case Phase::aborting:
    case Phase::halted:
      return link_.deadline();
    case Phase::greeting:
    case Phase::identifying:
      return link_.idle() ? phase_deadline_ : std::min(link_.deadline(), phase_deadline_);
    case Phase::ready:
      break;
  }
  double next = link_.deadline();
  if (link_.idle()) {
    next = std::min(poll_t_, build_t_);
    if (held_) next = std::min(next, room_t_);
    if (job_ && !held_) next = std::min(next, job_->next_question_t());
    next = std::min(next, std::max(toggle_t(), last_t_));
    if (!polls_.empty() || (!controls_.empty() && !held_)) next = last_t_;
  }
  if (job_) next = std::min(next, stats_t_ + kStatsPeriod_s);
  return next;
}

// After anything that may have changed what can be sent.
void Driver::settle(double t) {
  take_outcomes(t);
  if (job_ && job_->wants_halt()) return halt("M112 in the file", t);
  pump(t);
}

void Driver::take_outcomes(double t) {
  while (const auto outcome = link_.take()) {
    if (const auto* answer = std::get_if<Answer>(&*outcome)) {
      on_answer(*answer, t);
    } else if (const auto* accepted = std::get_if<Accepted>(&*outcome)) {
      if (room_) *room_ -= std::min(*room_, static_cast<std::uint32_t>(accepted->action.payload.size()));
      if (accepted->in_doubt) {
        ++doubts_;
        emit(Message{"a reply was lost and its command may have run twice"});
      }
      progress_t_ = t;
      if (act_by_job_ && job_) job_->on_accepted(*accepted);
    } else if (auto* no_room = std::get_if<NoRoom>(&*outcome)) {
      if (act_by_job_ && job_ && job_->stopping()) {
        job_->take_back();
      } else {
        hold(no_room->action, t);
      }
    } else if (const auto* refused = std::get_if<Refused>(&*outcome)) {
      on_refused(*refused);
    } else {
      on_dead(std::get<Dead>(*outcome), t);
    }
    if (phase_ == Phase::ready && job_ && job_->wants_abort()) abort_job(job_->outcome(), t);
    if (job_ && job_->over()) job_.reset();
  }
}

void Driver::on_refused(const Refused& refused) {
  const std::string command = hex(refused.action.payload.substr(0, 1));
  switch (refused.code) {
    case ReplyCode::cancelled:
      told_cancelled_ = true;  // and what more it says is asked next
      return;
    case ReplyCode::busy:
      if (!job_) return emit(Message{"not done: " + std::string(kBusy)});
      return drop_job(PrintFailed{kBusy});
    case ReplyCode::heater_failure:
      if (!job_) return disconnect(kHeatersShut);
      return drop_job(PrintFailed{kHeatersShut});
    default:
      emit(Message{"the printer's firmware does not know command " + command});
      if (!act_by_job_ || !job_) return;
      if (refused.action.kind == Action::Kind::other) return job_->on_left_out();
      return drop_job(PrintFailed{"the printer's firmware does not know command " + command});
  }
}

void Driver::on_dead(const Dead& dead, double t) {
  if (phase_ == Phase::halted) {
    if (t < greeting_until_) return link_.insist(Payload(Query::abort).bytes(), t);  // it may still boot
    phase_ = Phase::closed;
    return;
  }
  if (phase_ == Phase::ready && job_) return halt(dead.reason, t);  // which may still be heard
  drop_job(PrintFailed{dead.reason});
  disconnect(dead.reason);
}

void Driver::pump(double t) {
  if (phase_ == Phase::greeting || phase_ == Phase::identifying) {
    if (link_.idle() && t >= phase_deadline_) greet(t);
    return;
  }
  if (phase_ != Phase::ready) return;
  if (job_ && (job_->paused() || !job_->begun())) progress_t_ = t;
  if (job_ && t >= progress_t_ + kLongestCommand_s) return halt("the printer is stuck at one command", t);
  if (link_.idle() || link_.draining()) schedule_polls(t);
  if (link_.draining()) pump_aside(t);
  while (link_.idle() && pump_ready(t)) {
    take_outcomes(t);
    if (phase_ != Phase::ready) return;
  }
  if (job_ && job_->over()) job_.reset();
}

// When to press the printer's pause button: only in a print of ours, since firmware obeys it at any time.
double Driver::toggle_t() const noexcept {
  if (!toggle_pending_ || !build_known_ || !seen_running_ || !job_ || job_->ending()) return kNever;
  if (build_ != (wants_paused_ ? BuildState::running : BuildState::paused)) return kNever;
  return toggled_t_ + kToggleAgain_s;
}

// What cannot wait until a command's fate shows.
void Driver::pump_aside(double t) {
  // A glance would be at one command too many.
  if (std::exchange(glance_step_, 0) != 0) {
    polls_.clear();
    build_t_ = poll_t_ = t;
    schedule_polls(t);
  }
  if (job_ && job_->stopping()) {
    link_.give_up();
    job_->take_back();
    return;
  }
  polled_last_ = false;
  pump_query(t);
}

// The next packet; false when there is none to send.
bool Driver::pump_ready(double t) {
  if (pump_query(t)) return true;
  polled_last_ = false;
  return pump_action(t) || !polls_.empty();
}

bool Driver::pump_query(double t) {
  asked_by_job_ = asked_room_ = false;
  if (told_cancelled_) {
    link_.ask(question(Query::board_status), t);
    return true;
  }
  if (t >= toggle_t()) {
    toggled_t_ = t;
    build_t_ = t;
    link_.ask_once(Payload(Query::pause).bytes(), t);
    return true;
  }
  // Polls and actions take turns, but nothing comes between the queries of a glance.
  if (!polls_.empty() && (!polled_last_ || glance_step_ != 0)) {
    polled_last_ = true;
    link_.ask(std::move(polls_.front()), t);
    polls_.pop_front();
    return true;
  }
  return false;
}

bool Driver::pump_action(double t) {
  if (held_) {
    if (t < room_t_) return false;
    asked_room_ = true;
    link_.ask(question(Query::free_buffer), t);
    return true;
  }
  if (!controls_.empty()) {
    act_by_job_ = false;
    Action action = std::move(controls_.front());
    controls_.pop_front();
    act(std::move(action), t);
    return true;
  }
  if (!job_) return false;
  if (auto question = job_->question(t)) {
    asked_by_job_ = true;
    link_.ask(std::move(*question), t);
    return true;
  }
  if (auto action = job_->next()) {
    act_by_job_ = true;
    act(std::move(*action), t);
    return true;
  }
  return false;
}

void Driver::act(Action action, double t) {
  if (room_ && *room_ < action.payload.size()) {
    hold(std::move(action), t);
  } else {
    link_.act(std::move(action), t);
  }
}

void Driver::hold(Action action, double t) {
  held_ = std::move(action);
  room_asks_ = 0;
  room_t_ = t + kRoomPoll_s;
}

void Driver::on_room(const Answer& answer, double t) {
  if (answer.code != ReplyCode::ok || !held_) return;
  const std::uint32_t free = little_endian(answer.data, 0, 4);
  room_ = free < kPlenty ? std::optional(free) : std::nullopt;
  if (free >= held_->payload.size()) {
    Action action = std::move(*held_);
    held_.reset();
    link_.act(std::move(action), t);
    return;
  }
  room_t_ = t + (++room_asks_ > kEagerRoomPolls ? kRoomPollSlow_s : kRoomPoll_s);
}

void Driver::forget_sending() {
  controls_.clear();
  polls_.clear();
  held_.reset();
  room_.reset();
  glance_step_ = 0;
  told_cancelled_ = false;
}

void Driver::drop_job(decltype(Event::what) outcome) {
  if (!job_) return;
  if (act_by_job_) held_.reset();
  if (act_by_job_ && link_.draining()) link_.give_up();
  job_->drop(std::move(outcome));
  job_.reset();
}

void Driver::lost(const std::string& reason) {
  link_.output().clear();
  drop_job(PrintFailed{"connection lost: " + reason});
  disconnect(reason);
}

void Driver::disconnect(const std::string& reason) {
  phase_ = Phase::closed;
  forget_sending();
  if (std::exchange(connected_, false) || reason != last_loss_) emit(Disconnected{reason});
  last_loss_ = reason;
}

LinkStats Driver::link_stats() const {
  return {link_.packets_sent(), link_.resends(), link_.bytes_sent(), 0, doubts_};
}

void Driver::report_stats() { emit(link_stats().since(before_print_)); }

}  // namespace voidpath::fw::s3g

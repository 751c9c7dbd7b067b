#include "firmware-io/s3g/driver.h"

#include "firmware-io/heaters_off.h"
#include "firmware-io/lines_of.h"

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
    ask({Payload(Query::board_status).bytes(), 2}, t);
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
    ask(std::move(polls_.front()), t);
    polls_.pop_front();
    return true;
  }
  return false;
}

bool Driver::pump_action(double t) {
  if (held_) {
    if (t < room_t_) return false;
    asked_room_ = true;
    ask({Payload(Query::free_buffer).bytes(), 5}, t);
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
    ask(std::move(*question), t);
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

// Lift and park, cool down, motors free.
std::vector<std::string> Driver::leaving() const {
  std::vector<std::string> lines = options_.cancel_gcode;
  for (std::string& line : heaters_off(firmware_)) lines.push_back(std::move(line));
  lines.push_back("M84");
  return lines;
}

void Driver::print(std::unique_ptr<LineSource> source, double t) {
  last_t_ = t;
  if (phase_ != Phase::ready || job_) {
    emit(PrintFailed{job_ ? "a print is already running" : "the printer is not connected"});
    return;
  }
  stats_t_ = build_t_ = progress_t_ = t;
  before_print_ = link_stats();
  encoder_.restart();
  wants_paused_ = toggle_pending_ = seen_running_ = told_cancelled_ = false;
  PrintJob::Endings endings{leaving(), heaters_off(firmware_)};
  job_ = std::make_unique<PrintJob>(std::move(source), encoder_, std::move(endings), [this](auto what) {
    const bool last = std::holds_alternative<PrintFinished>(what) ||
                      std::holds_alternative<PrintCancelled>(what) ||
                      std::holds_alternative<PrintFailed>(what);
    if (last) report_stats();
    emit(std::move(what));
  });
  settle(t);
}

void Driver::pause() {
  if (!job_ || job_->ending()) return;
  job_->pause(false, "");
  want_paused(true);
}

void Driver::want_paused(bool paused) {
  wants_paused_ = paused;
  toggle_pending_ = true;
  build_known_ = false;
  build_t_ = 0;
}

void Driver::resume(double t) {
  last_t_ = t;
  if (!job_) return;
  job_->resume();
  want_paused(false);
  settle(t);
}

void Driver::end_job(std::vector<std::string> lines, decltype(Event::what) outcome, double t) {
  // A paused printer does nothing of what is queued; only an abort is heard.
  if (build_ == BuildState::paused) return abort_job(std::move(outcome), t);
  if (held_ && act_by_job_) {
    held_.reset();
    job_->take_back();
  }
  room_.reset();
  job_->end(std::move(lines), std::move(outcome));
  settle(t);
}

// The firmware itself stops, cools down and begins anew.
void Driver::abort_job(decltype(Event::what) outcome, double t) {
  job_->end({}, std::move(outcome));
  if (job_->over()) return job_.reset();
  forget_sending();
  phase_ = Phase::aborting;
  link_.insist(Payload(Query::abort).bytes(), t);
}

void Driver::on_aborted(ReplyCode code, double t) {
  if (code != ReplyCode::ok) {
    on_refused({{}, code});
    return disconnect(kHeatersShut);
  }
  drop_job(job_->outcome());
  phase_ = Phase::greeting;
  phase_deadline_ = t + 1;
  greeting_since(t);
}

void Driver::drop_job(decltype(Event::what) outcome) {
  if (!job_) return;
  if (act_by_job_) held_.reset();
  if (act_by_job_ && link_.draining()) link_.give_up();
  job_->drop(std::move(outcome));
  job_.reset();
}

void Driver::cancel(const std::string& reason, double t) {
  last_t_ = t;
  if (!job_ || job_->ending()) return;
  if (!reason.empty()) emit(Message{"cancelled: " + reason});
  end_job(leaving(), PrintCancelled{}, t);
}

void Driver::shut_down(double t) {
  last_t_ = t;
  if (!job_ || job_->ending()) return;
  std::vector<std::string> lines = heaters_off(firmware_);
  lines.insert(lines.end(), options_.cancel_gcode.begin(), options_.cancel_gcode.end());
  lines.push_back("M84");
  end_job(std::move(lines), PrintCancelled{}, t);
}

void Driver::halt(const std::string& reason, double t) {
  last_t_ = t;
  if (phase_ == Phase::closed || phase_ == Phase::halted) return;
  link_.insist(Payload(Query::abort).bytes(), t);
  forget_sending();
  drop_job(PrintFailed{reason});
  if (std::exchange(connected_, false)) emit(Disconnected{reason});
  last_loss_ = reason;
  phase_ = Phase::halted;
}

void Driver::command(const std::string& text, double t) {
  last_t_ = t;
  for (const std::string_view line : lines_of(text)) command_line(line, t);
}

void Driver::command_line(std::string_view line, double t) {
  if (phase_ != Phase::ready) {
    if (Words(line).letter() == 'M' && Words(line).code() == 112) return halt("emergency stop by command", t);
    return emit(Message{"not sent, the printer is not connected: " + std::string(line)});
  }
  try {
    Encoded encoded = encoder_.encode(line);
    for (const std::string& note : encoded.notes) emit(Message{note});
    if (encoded.host == Encoded::Host::halt) return halt("emergency stop by command", t);
    if (encoded.host == Encoded::Host::pause) pause();
    if (encoded.host == Encoded::Host::report) emit(Temperatures{sensors_});
    for (Action& action : encoded.actions) controls_.push_back(std::move(action));
  } catch (const EncodeError& error) {
    emit(Message{std::string("not sent: ") + error.what()});
  }
  settle(t);
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

void Driver::report_stats() {
  LinkStats stats = link_stats();
  stats.lines_sent -= before_print_.lines_sent;
  stats.resends -= before_print_.resends;
  stats.bytes_sent -= before_print_.bytes_sent;
  stats.doubts -= before_print_.doubts;
  emit(stats);
}

}  // namespace voidpath::fw::s3g

#include "firmware-io/heaters_off.h"
#include "firmware-io/lines_of.h"
#include "firmware-io/s3g/driver.h"

#include <utility>

/// What people and the rest of the program want of the printer: prints, pauses, ends, lines, emergency stops.
namespace voidpath::fw::s3g {

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
    if (ends_print(what)) report_stats();
    emit(std::move(what));
  });
  settle(t);
}

void Driver::pause() {
  if (!job_ || job_->ending()) return;
  job_->pause(false, "");
  want_paused(true);
}

void Driver::resume(double t) {
  last_t_ = t;
  if (!job_) return;
  job_->resume();
  want_paused(false);
  settle(t);
}

void Driver::want_paused(bool paused) {
  wants_paused_ = paused;
  toggle_pending_ = true;
  build_known_ = false;
  build_t_ = 0;
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

}  // namespace voidpath::fw::s3g

#include "firmware-io/marlin/driver.h"

#include "firmware-io/marlin/meatpack.h"
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
constexpr double kHot_c = 45;

// After the printer has said that it halts the port stays open so long, for its last words.
constexpr double kLastWords_s = 1;
// A firmware that reads M112 only behind what it has in hand may have had no room for it: said again so
// often, for so long, until it is heard.
constexpr double kRepeatHalt_s = 0.25;
constexpr double kMostHalting_s = 15;

// Marlin offers three at the most; more is noise.
constexpr int kMostChoices = 16;

const std::vector<std::string> kHeatersOff = {"M104 S0", "M140 S0", "M107"};

}  // namespace

Driver::Driver(DriverOptions options, const Clock& stamp, FlightRecorder& recorder,
               std::function<void(const Event&)> handler)
    : options_(std::move(options)),
      stamp_(stamp),
      recorder_(recorder),
      handler_(std::move(handler)),
      link_(options_.window, options_.timing, options_.byte_s, stamp, recorder) {}

void Driver::emit(decltype(Event::what) what) { handler_({stamp_.now_s(), std::move(what)}); }

void Driver::received(std::string_view bytes, double t) {
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
  }
}

void Driver::dispatch(const std::string& line, double t) {
  recorder_.received(stamp_.now_s(), line);
  const Reply reply = parse_reply(line);
  if (phase_ == Phase::identifying || phase_ == Phase::ready) link_.on_reply(reply, t);
  if (phase_ == Phase::identifying || queries_unanswered_ > 0) settings_.take(line);
  if (phase_ == Phase::ready) {
    dispatch_ready(reply, t);
  } else if (phase_ == Phase::halted) {
    emit(Message{line});
    const auto* error = std::get_if<Error>(&reply);
    if ((error != nullptr && error->kind == Error::Kind::fatal) || std::holds_alternative<Start>(reply)) {
      halting_until_ = t;
      enter(Phase::halted, t + kLastWords_s);
    }
  } else {
    dispatch_handshake(reply, t);
  }
}

void Driver::dispatch_ready(const Reply& reply, double t) {
  if (const auto* ok = std::get_if<Ok>(&reply)) {
    collect(t);
    // Commands run one after the other: this is the ok of the one that waited for a person.
    panel_waits_ = false;
    if (std::exchange(printer_waits_, false)) go_on(t);
    if (!ok->sensors.empty()) note_sensors(ok->sensors);
    if (job_) job_->on_ok(link_, !ok->sensors.empty(), t);
    drop_finished_job();
  } else if (const auto* report = std::get_if<TemperatureReport>(&reply)) {
    if (report->waiting) link_.note_progress(t);
    note_sensors(report->sensors);
    // Repetier's M105 says ok first and the temperatures on a line of their own.
    if (job_ && !report->waiting && !reports_by_itself()) {
      job_->on_ok(link_, true, t);
      drop_finished_job();
    }
  } else if (const auto* error = std::get_if<Error>(&reply)) {
    on_error(*error, t);
  } else if (const auto* busy = std::get_if<Busy>(&reply)) {
    link_.note_busy(t);
    if (busy->for_user) {
      link_.hold();
      panel_waits_ = true;
      emit(Message{busy->why});
      if (job_ && job_->goes_on()) {
        printer_waits_ = true;
        job_->pause(true, busy->why);
      }
    }
  } else if (std::holds_alternative<Start>(reply)) {
    on_restart(t);
  } else if (const auto* action = std::get_if<Action>(&reply)) {
    on_action(*action, t);
  } else if (const auto* echo = std::get_if<Echo>(&reply)) {
    if (queries_unanswered_ == 0) emit(Message{echo->text});
    const bool odd =
        echo->text.starts_with("Unknown command") || echo->text.starts_with("too long extrusion");
    if (job_ && odd) ++odd_commands_;
    // From here on the print lacks filament: a person decides whether it is worth going on.
    if (job_ && echo->text.find("extrusion prevented") != std::string::npos) job_->pause(true, echo->text);
  } else if (const auto* other = std::get_if<Other>(&reply)) {
    if (queries_unanswered_ == 0) emit(Message{other->text});
  } else if (const auto* state = std::get_if<PackState>(&reply)) {
    packing_answered(*state);
  } else if (const auto* overrun = std::get_if<Overrun>(&reply)) {
    emit(Message{overrun->text});
  } else if (const auto* firmware = std::get_if<Firmware>(&reply)) {
    emit(Message{firmware->info.name});
  }
}

void Driver::on_error(const Error& error, double t) {
  if (error.kind == Error::Kind::framing) return;  // the window's business
  emit(Message{"Error: " + error.text});
  if (error.kind != Error::Kind::fatal) return;
  for (const std::string& line : kHeatersOff) link_.send_raw(line, false, t);
  fail(error.text);
}

void Driver::on_restart(double t) {
  const std::string reason = "the printer restarted";
  if (job_) {
    report_stats();
    job_.reset();
    emit(PrintFailed{reason + " in mid-print"});
  }
  forget_dialogue();
  link_.drop_output();
  if (std::exchange(connected_, false)) emit(Disconnected{reason});
  start_seen_ = true;
  greetings_ = 0;
  enter(Phase::booting, t + options_.handshake.banner_quiet_s);
}

void Driver::on_action(const Action& action, double t) {
  if (action.name.starts_with("prompt_")) return on_prompt(action);
  emit(Message{"action: " + action.name + (action.argument.empty() ? "" : " " + action.argument)});
  if (action.name == "pause" || action.name == "paused" || action.name == "out_of_filament") {
    if (job_) job_->pause(true, action.argument.empty() ? "the printer asked for it" : action.argument);
    if (action.name == "paused") link_.hold(), panel_waits_ = true;
  } else if (action.name == "resume" || action.name == "resumed") {
    go_on(t);
  } else if (action.name == "cancel") {
    cancel("the printer asked for it", t);
  }
}

// The answer is M876, which command() sends at once.
void Driver::on_prompt(const Action& action) {
  if (action.name == "prompt_begin") {
    prompt_ = "the printer asks: " + action.argument;
    prompt_choices_ = 0;
  } else if (action.name == "prompt_choice" || action.name == "prompt_button") {
    if (prompt_choices_ < kMostChoices)
      prompt_ += "; M876 S" + std::to_string(prompt_choices_++) + ": " + action.argument;
  } else if (action.name == "prompt_show" && !prompt_.empty()) {
    emit(Message{prompt_});
  } else if (action.name == "prompt_end") {
    prompt_.clear();
  }
}

void Driver::note_sensors(const Sensors& sensors) {
  hot_ = std::any_of(sensors.begin(), sensors.end(), [](const auto& sensor) {
    return sensor.second.actual_c > kHot_c || sensor.second.target_c > 0;
  });
  polled_t_ = received_t_;
  emit(Temperatures{sensors});
}

void Driver::collect(double t) {
  while (const auto tag = link_.take_acknowledged()) {
    if (tag->kind == Tag::Kind::query) {
      if (--queries_unanswered_ == 0) tell_limits();
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

void Driver::drop_finished_job() {
  if (job_ && job_->over()) job_.reset();
}

void Driver::pump(double t) {
  link_.pump(t);
  if (link_.wants_question()) link_.ask(t);
  if (packing_again(t)) return;
  while (!queries_.empty() && link_.may_send(queries_.front())) {
    link_.send(queries_.front(), {.kind = Tag::Kind::query}, t);
    queries_.pop_front();
  }
  while (!controls_.empty() && link_.may_send(controls_.front())) {
    const std::string line = std::move(controls_.front());
    controls_.pop_front();
    link_.send(line, {.kind = Tag::Kind::control, .is_long = is_long(line)}, t);
  }
  if (job_ && queries_unanswered_ == 0) job_->feed(link_, t);
  drop_finished_job();
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
      fail("the printer refuses one line again and again");
      break;
    case Window::Health::no_history:
      fail("the printer asks for a line that was never sent or is long gone");
      break;
    case Window::Health::silent:
      fail("the printer no longer answers");
      break;
    case Window::Health::restarted:
      on_restart(t);
      break;
  }
}

// The dialogue cannot go on: what may still be heard is M112.
void Driver::fail(const std::string& reason) {
  if (job_) {
    link_.send_raw("\nM112", false, received_t_);
    report_stats();
    job_.reset();
    emit(PrintFailed{reason});
  }
  disconnect(reason);
}

void Driver::disconnect(const std::string& reason) {
  phase_ = Phase::closed;
  forget_dialogue();
  if (std::exchange(connected_, false) || reason != last_loss_) emit(Disconnected{reason});
  last_loss_ = reason;
}

void Driver::lost(const std::string& reason) {
  link_.drop_output();
  if (job_) {
    report_stats();
    job_.reset();
    emit(PrintFailed{"connection lost: " + reason});
  }
  disconnect(reason);
}

void Driver::elapsed(double t) {
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
  if (job_ && job_->heating()) return kNever;  // its answer would come only after the wait
  if (!reports_by_itself()) return polled_t_ + (hot_ ? kPollHot_s : kPollCold_s);
  // While lines are out the stall timers watch.
  return link_.all_acknowledged() ? std::max(received_t_, polled_t_) + kMute_s : kNever;
}

void Driver::poll_temperature(double t) {
  polled_t_ = t;
  if (controls_.empty()) controls_.push_back("M105");
}

LinkStats Driver::link_stats() const {
  const Window& window = link_.window();
  return {link_.lines_sent(), window.resend_requests(), link_.bytes_sent(), window.limit_bytes(),
          window.doubtful_requests() + window.nameless_oks() + odd_commands_};
}

void Driver::report_stats() {
  LinkStats stats = link_stats();
  stats.lines_sent -= before_print_.lines_sent;
  stats.resends -= before_print_.resends;
  stats.bytes_sent -= before_print_.bytes_sent;
  stats.doubts -= before_print_.doubts;
  emit(stats);
}

void Driver::print(std::unique_ptr<LineSource> source, double t) {
  if (phase_ != Phase::ready || job_) {
    emit(PrintFailed{job_ ? "a print is already running" : "the printer is not connected"});
    return;
  }
  stats_t_ = t;
  end_probed_ = false;
  before_print_ = link_stats();
  job_ = std::make_unique<PrintJob>(std::move(source), [this](auto what) {
    const bool last = std::holds_alternative<PrintFinished>(what) ||
                      std::holds_alternative<PrintCancelled>(what) ||
                      std::holds_alternative<PrintFailed>(what);
    if (last) report_stats();
    emit(std::move(what));
  });
  if (panel_waits_) {
    printer_waits_ = true;
    job_->pause(true, "the printer waits for a person");
  }
  settle(t);
}

void Driver::pause() {
  printer_waits_ = false;  // a person's wish outlasts the printer's
  if (job_) job_->pause(false, "");
}

void Driver::resume(double t) {
  leave_panel(t);
  go_on(t);
}

// The printer waits for a person, who is here: else it would go on waiting for one at its panel.
void Driver::leave_panel(double t) {
  printer_waits_ = false;
  if (!std::exchange(panel_waits_, false)) return;
  link_.send_raw("M108", true, t);
  link_.note_progress(t);
}

void Driver::go_on(double t) {
  if (!job_) return;
  link_.note_progress(t);
  job_->resume();
  settle(t);
}

void Driver::cancel(const std::string& reason, double t) {
  if (!job_) return;
  std::vector<std::string> lines = options_.cancel_gcode;
  lines.insert(lines.end(), kHeatersOff.begin(), kHeatersOff.end());
  lines.push_back("M84");
  if (!job_->ending() && !reason.empty()) emit(Message{"cancelled: " + reason});
  leave_panel(t);
  job_->end(std::move(lines), PrintCancelled{}, link_, t);
  settle(t);
}

void Driver::shut_down(double t) {
  if (!job_) return;
  std::vector<std::string> lines = kHeatersOff;
  lines.insert(lines.end(), options_.cancel_gcode.begin(), options_.cancel_gcode.end());
  lines.push_back("M84");
  leave_panel(t);
  job_->end(std::move(lines), PrintCancelled{}, link_, t);
  settle(t);
}

void Driver::halt(const std::string& reason, double t) {
  if (phase_ == Phase::closed || phase_ == Phase::halted) return;
  urgent_ = true;
  link_.drop_output();
  // A printer that was connected before, and not reset since, may still unpack.
  if (packed_once_) link_.output() += kPackingOff;
  if (job_) {
    report_stats();
    job_.reset();
    emit(PrintFailed{reason});
  }
  forget_dialogue();
  last_loss_ = reason;
  if (std::exchange(connected_, false)) emit(Disconnected{reason});
  halting_until_ = t + kMostHalting_s;
  say_halt(t);
}

void Driver::say_halt(double t) {
  // The newline ends a line cut off in the middle. Unnumbered is seen at once by firmware without emergency
  // parser, numbered by the rest that insists on numbers.
  link_.send_raw("\nM112", false, t);
  link_.send_raw(frame(link_.window().next_number(), "M112"), false, t);
  enter(Phase::halted, t + kRepeatHalt_s);
}

void Driver::command(const std::string& raw, double t) {
  const std::string line = sanitise(raw);
  if (line.empty()) return;
  const Word word = first_word(line);
  if (word == Word{'M', 112}) return halt("emergency stop by command", t);
  if (phase_ != Phase::ready) return emit(Message{"not sent, the printer is not connected: " + line});
  if (sets_line_number(line) || line.size() > kMaxPayload) return emit(Message{"not sent: " + line});
  if (is_out_of_band(line)) {
    link_.send_raw(line, true, t);
  } else {
    controls_.push_back(line);
  }
  settle(t);
}

}  // namespace voidpath::fw::marlin

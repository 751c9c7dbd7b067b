#include "firmware-io/heaters_off.h"
#include "firmware-io/marlin/driver.h"
#include "firmware-io/marlin/words.h"

#include <algorithm>
#include <utility>

/// What the printer says while it is ready, and what that changes.
namespace voidpath::fw::marlin {
namespace {

constexpr double kHot_c = 45;

// Marlin offers three at the most; more is noise.
constexpr int kMostChoices = 16;

constexpr std::string_view kUnknown = "Unknown command";
// What a firmware complains of stands in its command queue or has just left it: more lines than any queue
// holds.
constexpr std::uint32_t kLookBack = 128;

std::string_view quoted_in(std::string_view refusal) {
  const auto first = refusal.find('"'), last = refusal.rfind('"');
  return first == last ? std::string_view{} : refusal.substr(first + 1, last - first - 1);
}

std::string without_blanks(std::string_view text) {
  std::string out(text);
  std::erase(out, ' ');
  return out;
}

}  // namespace

void Driver::dispatch_ready(const Reply& reply, double t) {
  if (const auto* ok = std::get_if<Ok>(&reply)) {
    name_told_ = false;
    collect(t);
    waits_no_more(t);
    if (!ok->sensors.empty()) note_sensors(ok->sensors);
    if (job_) job_->on_ok(link_, !ok->sensors.empty(), t);
    drop_finished_job();
  } else if (const auto* report = std::get_if<TemperatureReport>(&reply)) {
    // One that reports unasked only while it waits for a temperature, as Klipper, does not say that it waits.
    if (report->waiting || (job_ && job_->heating() && !reports_by_itself())) link_.note_heating(t);
    note_sensors(report->sensors);
    // Repetier's M105 says ok first and the temperatures on a line of their own.
    if (!report->waiting && !reports_by_itself()) {
      link_.on_answer_apart(t);
      collect(t);
      if (job_) job_->on_ok(link_, true, t);
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
      } else if (job_ && job_->ending() && may_leave_panel()) {
        leave_panel(t);  // a filament change waits more than once
      }
    }
  } else if (std::holds_alternative<Start>(reply)) {
    on_restart(t);
  } else if (const auto* action = std::get_if<Action>(&reply)) {
    on_action(*action, t);
  } else if (const auto* echo = std::get_if<Echo>(&reply)) {
    on_echo(echo->text);
  } else if (const auto* other = std::get_if<Other>(&reply)) {
    if (queries_unanswered_ == 0 && !name_told_) emit(Message{other->text});
  } else if (const auto* state = std::get_if<PackState>(&reply)) {
    packing_answered(*state);
  } else if (const auto* overrun = std::get_if<Overrun>(&reply)) {
    emit(Message{overrun->text});
  } else if (const auto* firmware = std::get_if<Firmware>(&reply)) {
    name_told_ = link_.on_name(t);
    if (!name_told_) return emit(Message{firmware->info.name});
    collect(t);
    waits_no_more(t);
  }
}

// Commands run one after the other: that of which this is the ok, or the end, was the one that waited for a
// person.
void Driver::waits_no_more(double t) {
  panel_waits_ = false;
  panel_words_ = 0;
  if (std::exchange(printer_waits_, false)) go_on(t);
}

void Driver::on_echo(const std::string& text) {
  if (queries_unanswered_ == 0) emit(Message{text});
  if (!job_) return;
  const bool unknown = text.starts_with(kUnknown), meant = unknown && was_sent(text);
  if (text.starts_with("too long extrusion") || (unknown && !meant)) ++odd_commands_;
  // Whoever wrote the file wanted a person here, to change the filament.
  if (meant && wants_person(quoted_in(text))) job_->pause(true, text);
  // From here on the print lacks filament: a person decides whether it is worth going on.
  if (text.find("extrusion prevented") != std::string::npos) job_->pause(true, text);
}

// Whether what the firmware does not know stands in a line of ours: then the line was not damaged. Marlin
// quotes all of it, Klipper its first word.
bool Driver::was_sent(std::string_view refusal) const {
  const std::string_view quoted = quoted_in(refusal);
  if (quoted.empty()) return false;
  const std::string wanted = without_blanks(quoted);
  const Window& window = link_.window();
  for (std::uint32_t n = window.next_number(), i = 0; i < kLookBack && n > window.first_kept(); ++i) {
    const std::string& line = window.kept(--n);
    if (line.substr(0, line.find(' ')) == quoted || without_blanks(line) == wanted) return true;
  }
  return false;
}

void Driver::on_error(const Error& error, double t) {
  if (error.kind == Error::Kind::framing) return;  // the window's business
  emit(Message{"Error: " + error.text});
  // A part of the print is missing: a person decides, as above.
  if (error.kind == Error::Kind::refused && job_) job_->pause(true, error.text);
  if (error.kind == Error::Kind::refused) unparking_ = false;
  if (error.kind != Error::Kind::fatal) return;
  for (const std::string& line : heaters_off(firmware_)) link_.send_raw(line, false, t);
  if (job_) {
    link_.send_raw("\nM112", false, t);
    report_stats();
    job_.reset();
    emit(PrintFailed{error.text});
  }
  disconnect(error.text);
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
  if (action.name == "probe_failed") {
    if (job_) job_->pause(true, "probing failed");
  } else if (action.name == "pause" || action.name == "paused" || action.name == "out_of_filament") {
    if (job_) job_->pause(true, action.argument.empty() ? "the printer asked for it" : action.argument);
    if (action.name != "paused") return;
    link_.hold();
    panel_waits_ = true;
    parked_ = parking_of(firmware_.name);
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
    emit(Message{prompt_, true});
  } else if (action.name == "prompt_end") {
    prompt_.clear();
  }
}

// What it tells a temperature of it may heat, whatever it said of itself: Klipper says nothing.
void Driver::note_heaters(const Sensors& sensors) {
  int tools = 1;
  while (tools < kMostExtruders && sensors.count("T" + std::to_string(tools)) > 0) ++tools;
  firmware_.extruders = std::max(firmware_.extruders, tools);
  if (sensors.count("C") > 0) firmware_.capabilities["CHAMBER_TEMPERATURE"] = true;
}

void Driver::note_sensors(const Sensors& sensors) {
  hot_ = std::any_of(sensors.begin(), sensors.end(), [](const auto& sensor) {
    return sensor.second.actual_c > kHot_c || sensor.second.target_c > 0;
  });
  note_heaters(sensors);
  polled_t_ = received_t_;
  emit(Temperatures{sensors});
}

}  // namespace voidpath::fw::marlin

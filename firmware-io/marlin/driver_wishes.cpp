#include "firmware-io/heaters_off.h"
#include "firmware-io/lines_of.h"
#include "firmware-io/marlin/driver.h"
#include "firmware-io/marlin/meatpack.h"
#include "firmware-io/marlin/words.h"

#include <utility>

/// What people and the rest of the program want of the printer: prints, pauses, ends, lines, emergency stops.
namespace voidpath::fw::marlin {
namespace {

// A firmware that reads M112 only behind what it has in hand may have had no room for it: said again so
// often, for so long, until it is heard.
constexpr double kRepeatHalt_s = 0.25;
constexpr double kMostHalting_s = 15;
// An M108 stands in the firmware's queue behind what waits, and M112 must find room; where it needs none, in
// the receive buffer.
constexpr int kMostPanelWords = 2, kMostWordsOutOfBand = 16;

}  // namespace

void Driver::print(std::unique_ptr<LineSource> source, double t) {
  stamp_.look();
  if (phase_ != Phase::ready || job_) {
    emit(PrintFailed{job_ ? "a print is already running" : "the printer is not connected"});
    return;
  }
  stats_t_ = t;
  end_probed_ = false;
  before_print_ = link_stats();
  job_ = std::make_unique<PrintJob>(std::move(source), firmware_, [this](auto what) {
    if (ends_print(what)) report_stats();
    emit(std::move(what));
  });
  if (panel_waits_) {
    printer_waits_ = true;
    job_->pause(true, "the printer waits for a person");
  }
  settle(t);
}

void Driver::pause() {
  stamp_.look();
  printer_waits_ = false;  // a person's wish outlasts the printer's
  if (job_) job_->pause(false, "");
}

void Driver::resume(double t) {
  stamp_.look();
  leave_panel(t);
  if (!parked_ || !job_) return go_on(t);
  if (!std::exchange(unparking_, true)) controls_.emplace_back(parked_->resume);
  settle(t);
}

bool Driver::may_leave_panel() const {
  return panel_words_ < (offers("EMERGENCY_PARSER") ? kMostWordsOutOfBand : kMostPanelWords);
}

// The printer waits for a person, who is here: else it would go on waiting for one at its panel.
void Driver::leave_panel(double t) {
  printer_waits_ = false;
  if (!std::exchange(panel_waits_, false)) return;
  if (!parked_ || parked_->knows_m108) link_.send_raw("M108", true, t), ++panel_words_;
  link_.note_progress(t);
}

void Driver::go_on(double t) {
  parked_ = nullptr;
  unparking_ = false;
  if (!job_) return;
  link_.note_progress(t);
  job_->resume();
  settle(t);
}

// A printer that was left paused would pause no other print.
std::vector<std::string> Driver::last_lines(std::vector<std::string> lines) {
  lines.push_back("M84");
  if (const Parking* parked = std::exchange(parked_, nullptr)) lines.emplace_back(parked->forget);
  return lines;
}

void Driver::cancel(const std::string& reason, double t) {
  stamp_.look();
  if (!job_) return;
  // Not every firmware says that it waits again.
  if (job_->ending() && link_.waits_at_length() && may_leave_panel()) panel_waits_ = true;
  leave_panel(t);
  if (job_->ending()) return;
  std::vector<std::string> lines = options_.cancel_gcode;
  for (std::string& line : heaters_off(firmware_)) lines.push_back(std::move(line));
  if (!reason.empty()) emit(Message{"cancelled: " + reason});
  job_->end(last_lines(std::move(lines)), PrintCancelled{}, link_, t);
  settle(t);
}

void Driver::shut_down(double t) {
  stamp_.look();
  if (!job_) return;
  std::vector<std::string> lines = heaters_off(firmware_);
  lines.insert(lines.end(), options_.cancel_gcode.begin(), options_.cancel_gcode.end());
  leave_panel(t);
  job_->end(last_lines(std::move(lines)), PrintCancelled{}, link_, t);
  settle(t);
}

void Driver::halt(const std::string& reason, double t) {
  stamp_.look();
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

void Driver::command(const std::string& text, double t) {
  stamp_.look();
  for (const std::string_view line : lines_of(text)) command_line(line, t);
}

void Driver::command_line(std::string_view raw, double t) {
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

void Driver::drop_finished_job() {
  if (job_ && job_->over()) job_.reset();
}

LinkStats Driver::link_stats() const {
  const Window& window = link_.window();
  return {link_.lines_sent(), window.resend_requests(), link_.bytes_sent(), window.limit_bytes(),
          window.doubtful_requests() + window.nameless_oks() + odd_commands_};
}

void Driver::report_stats() { emit(link_stats().since(before_print_)); }

}  // namespace voidpath::fw::marlin

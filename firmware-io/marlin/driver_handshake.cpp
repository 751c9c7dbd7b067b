#include "firmware-io/marlin/driver.h"
#include "firmware-io/marlin/meatpack.h"

#include <algorithm>
#include <cmath>
#include <utility>

/// From an open port to a printer that is known: wait for its boot, set the line number, ask who it is.
namespace voidpath::fw::marlin {
namespace {

constexpr int kGreetings = 3;
// A printer that was heard to boot may sit in its boot screen for half a minute. Beyond the third each
// greeting is waited for twice as long as the one before, so that all of them find room in its receive
// buffer.
constexpr int kGreetingsAfterBoot = 6;
constexpr int kPackingQuestions = 3;

// A firmware busy with a long command says so and gets more time.
constexpr double kBusyGrace_s = 5;

// Marlin 2 reads words that no blank divides, an E behind a number included. Others may take that E for an
// exponent.
bool reads_dense_moves(const std::string& firmware) {
  return firmware.starts_with("Marlin 2.") || firmware.starts_with("Marlin bugfix-2.");
}

// Marlin before 1.1 and many a Repetier end a line there; firmware that is not known may descend from them.
bool colon_ends_line(const std::string& firmware) {
  for (const char* family :
       {"Marlin 1.1", "Marlin 2", "Marlin bugfix", "Prusa-Firmware", "Klipper", "Smoothie", "RepRapFirmware"})
    if (firmware.find(family) != firmware.npos) return false;
  return true;
}

}  // namespace

void Driver::opened(double t) {
  stamp_.look();
  splitter_.clear();
  link_.output().clear();
  link_.restart(0);
  forget_dialogue();
  link_.forget_packing();
  start_seen_ = halt_heard_ = false;
  greetings_ = 0;
  received_t_ = t;
  enter(Phase::booting, t + options_.handshake.boot_wait_s);
}

void Driver::forget_dialogue() {
  controls_.clear();
  queries_.clear();
  queries_unanswered_ = 0;
  repacking_until_ = rest_until_ = 0;
  settings_ = {};
  firmware_ = {};
  panel_words_ = 0;
  name_told_ = autoreport_ = printer_waits_ = panel_waits_ = unparking_ = false;
  parked_ = nullptr;
  prompt_.clear();
}

void Driver::greet(double t) {
  if (++greetings_ > (start_seen_ ? kGreetingsAfterBoot : kGreetings))
    return disconnect("the printer does not answer");
  // The empty line ends whatever garbage stands in the printer's line buffer.
  link_.restart(0);
  link_.forget_packing();
  link_.set_colon_ends_line(true);
  link_.set_dense(false);
  link_.set_piecewise(false);
  link_.set_ok_at_enqueue(false);
  // A firmware that was not reset may still unpack; one that knows nothing of it is spared the bytes at
  // first.
  if (packed_once_ || greetings_ > 1) link_.output() += kPackingOff;
  link_.output() += "\n";
  link_.send_raw("N0 M110 N0*125", false, t);
  link_.forget_round_trip();
  asked_t_ = t;
  enter(Phase::greeting, t + std::ldexp(options_.handshake.answer_s, std::max(greetings_ - kGreetings, 0)));
}

void Driver::dispatch_handshake(const Reply& reply, double t) {
  const HandshakeTiming& timing = options_.handshake;
  if (std::holds_alternative<Start>(reply)) {
    start_seen_ = true;
    greetings_ = 0;
    return enter(Phase::booting, t + timing.banner_quiet_s);
  }
  if (const auto* report = std::get_if<TemperatureReport>(&reply)) note_sensors(report->sensors);
  if (phase_ == Phase::booting && start_seen_) {
    phase_deadline_ = t + timing.banner_quiet_s;
  } else if (phase_ == Phase::greeting) {
    if (std::holds_alternative<Busy>(reply)) phase_deadline_ = t + kBusyGrace_s;
    if (std::holds_alternative<Ok>(reply) || std::holds_alternative<Wait>(reply)) {
      link_.learn_round_trip(t - asked_t_);
      enter(Phase::settling, t + timing.settle_s);
    }
  } else if (phase_ == Phase::identifying) {
    if (std::holds_alternative<Busy>(reply)) {
      link_.note_busy(t);
      phase_deadline_ = t + kBusyGrace_s;
    } else if (const auto* firmware = std::get_if<Firmware>(&reply)) {
      link_.first_line_answered();
      link_.learn_round_trip(t - asked_t_);  // the greeting may have waited behind the boot
      auto capabilities = std::move(firmware_.capabilities);
      firmware_ = firmware->info;
      firmware_.capabilities = std::move(capabilities);
    } else if (const auto* capability = std::get_if<Capability>(&reply)) {
      firmware_.capabilities[capability->name] = capability->on;
    }
  } else if (phase_ == Phase::packing) {
    if (const auto* state = std::get_if<PackState>(&reply); state && state->on && state->no_spaces) {
      link_.start_packing();
      become_ready(t);
    }
  }
}

void Driver::handshake_elapsed(double t) {
  switch (phase_) {
    case Phase::booting:
    case Phase::greeting:
      greet(t);
      break;
    case Phase::settling:
      link_.restart(0);
      enter(Phase::identifying, t + options_.handshake.identify_s);
      asked_t_ = t;
      link_.send("M115", {}, t);
      break;
    case Phase::identifying:
      if (link_.all_acknowledged()) {
        ask_packing(t);
      } else {
        disconnect("the printer does not say who it is");
      }
      break;
    case Phase::packing:
      ask_packing(t);
      break;
    case Phase::halted:
      if (t < halting_until_) return say_halt(t);
      phase_ = Phase::closed;
      break;
    case Phase::ready:
    case Phase::closed:
      break;
  }
}

// On without blanks, or not at all.
void Driver::ask_packing(double t) {
  if (phase_ != Phase::packing) packing_asked_ = 0;
  if (!options_.meatpack || !offers("MEATPACK")) return become_ready(t);
  packed_once_ = true;
  link_.packing_tried();
  link_.output() += kPackingOff;
  if (packing_asked_++ == kPackingQuestions) return become_ready(t);
  link_.output() += kPackingOn;
  enter(Phase::packing, t + options_.handshake.packing_s);
}

// In mid-print: everything sent must have been taken before, for the firmware unpacks whatever comes behind.
bool Driver::packing_again(double t) {
  if (repacking_until_ > 0) return true;
  if (!link_.packing_due()) return false;
  if (!link_.all_acknowledged()) return true;
  link_.output() += kPackingOff;
  link_.output() += kPackingOn;
  repacking_until_ = t + options_.handshake.packing_s;
  return true;
}

void Driver::packing_answered(const PackState& state) {
  if (repacking_until_ == 0 || !state.on || !state.no_spaces) return;
  repacking_until_ = 0;
  link_.start_packing();
}

void Driver::packing_unanswered() {
  repacking_until_ = 0;
  link_.output() += kPackingOff;
  link_.packing_failed();
}

void Driver::become_ready(double t) {
  phase_ = Phase::ready;
  connected_ = true;
  last_loss_.clear();
  polled_t_ = 0;
  const bool marlin_2 = reads_dense_moves(firmware_.name);
  link_.set_colon_ends_line(colon_ends_line(firmware_.name));
  link_.set_dense(marlin_2);
  link_.set_piecewise(marlin_2);
  link_.set_ok_at_enqueue(firmware_.name.find("Repetier") != firmware_.name.npos);
  autoreport_ = offers("AUTOREPORT_TEMP");
  if (reports_by_itself()) {
    controls_.push_back("M155 S1");
    polled_t_ = t;
  }
  ask_firmware();
  emit(Connected{firmware_});
}

// How it is set up; and that it is to say when it is busy, which many are built without: those answer that
// they do not know the command. Klipper and Repetier know none of these; Smoothie means other things by the
// same letters.
void Driver::ask_firmware() {
  const auto named = [&](const char* name) { return firmware_.name.find(name) != std::string::npos; };
  if (firmware_.name.empty() || named("Klipper") || named("Repetier") || named("Smoothie")) return;
  queries_ = {"M503", "M211"};
  if (options_.keepalive_s > 0 && (named("Marlin") || named("Prusa-Firmware")))
    queries_.push_front("M113 S" + std::to_string(options_.keepalive_s));
  queries_unanswered_ = static_cast<int>(queries_.size());
}

void Driver::tell_limits() {
  auto limits = settings_.limits();
  if (!limits) return;
  limits->line_form = link_.packing()                     ? LineForm::packed
                      : reads_dense_moves(firmware_.name) ? LineForm::dense
                                                          : LineForm::plain;
  emit(LimitsKnown{*limits});
}

}  // namespace voidpath::fw::marlin

// What the firmware says, what it dies of, and what is counted.

#include "tests/mock_printer/mock_marlin.h"

#include <algorithm>
#include <charconv>

namespace voidpath::test::mock {

std::string fixed(double value, int decimals) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, decimals).ptr;
  std::string result(text, end);
  // A rounded-off negative is zero.
  if (result.front() == '-' && result.find_first_not_of("-0.") == result.npos) result.erase(0, 1);
  return result;
}

void MockMarlin::refuse(const RefusedLine& refused) {
  write_line(options_.dialect.error_prefix + refused.error);
  ask_for(refused.resend);
}

void MockMarlin::ask_for(std::int64_t number) {
  ++totals_.resends;
  ring_.clear();
  protocol_.drop_partial();
  protocol_.note_request();
  write_line(options_.dialect.resend_prefix + std::to_string(number));
  if (options_.dialect.resend_ok && !faults_.resend_lacks_ok()) send_ok("");
}

/// As the firmware counts: the command whose ok this is still holds its place.
std::string MockMarlin::free_slots() const {
  const std::size_t used = std::min(options_.queue, queue_.size() + 1);
  return " P" + std::to_string(motion_.planner().free()) + " B" + std::to_string(options_.queue - used);
}

void MockMarlin::send_ok(std::string_view tail) {
  std::string line = "ok";
  line += tail;
  int times = 1;
  if (!faults_.none()) {
    for (const Fault& fault : faults_.at_ok()) {
      if (fault.kind == FaultKind::kLoseOk) times = 0;
      if (fault.kind == FaultKind::kDoubleOk) times = 2;
      if (fault.kind == FaultKind::kGarbleOk) line[0] = static_cast<char>(line[0] ^ (1 << faults_.pick(5)));
      if (natural_trigger(fault.kind) == FaultTrigger::kLine) apply(fault);
    }
  }
  while (times-- > 0) write_line(line);
}

void MockMarlin::write_line(std::string_view text) { write(std::string(text) + '\n'); }

void MockMarlin::write(std::string_view text) {
  std::string damaged;
  if (!faults_.none()) {
    for (const char c : text) faults_.pass_byte(c, true, damaged);
    text = damaged;
  }
  if (options_.baud > 0 || options_.round_trip_s > 0)
    wire_out_.send(now_, text);
  else
    ready_out_ += text;
}

std::string MockMarlin::take_output() {
  std::string result;
  result.swap(ready_out_);
  return result;
}

std::optional<double> MockMarlin::take_unplug() {
  const auto seconds = unplug_;
  unplug_.reset();
  return seconds;
}

std::string MockMarlin::temperatures() const {
  const bool bare = options_.dialect.bare_temperatures;
  const auto one = [&](const char* name, const GuardedHeater& heater) {
    Heater present = heater.heater();
    present.update(now_);
    const int decimals = bare ? 1 : 2;
    return name + fixed(present.temperature(), decimals) + " /" + fixed(present.target(), decimals);
  };
  if (bare) return one("B:", bed_) + " " + one("T0:", hotend_);
  return one("T:", hotend_) + " " + one("B:", bed_) + " @:" + std::to_string(hotend().power()) +
         " B@:" + std::to_string(bed().power());
}

void MockMarlin::apply(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::kReset:
      reset();
      break;
    case FaultKind::kHalt:
      kill(fault.text, fault.heater == "bed" ? "bed" : "E0");
      break;
    case FaultKind::kUnplug:
      unplug_ = fault.seconds;
      break;
    case FaultKind::kSilence:
      silent_until_ = now_ + fault.seconds;
      break;
    case FaultKind::kSlow:
      slow_s_ = fault.seconds;
      slow_commands_ = fault.lines;
      break;
    case FaultKind::kDeadHeater:
      (fault.heater == "bed" ? bed_ : hotend_).heater().break_element();
      break;
    case FaultKind::kPause:
      queue_.push_back({"M600", std::nullopt, true});
      break;
    default:
      break;
  }
}

/// What a line gets that comes after a halt, where anything answers.
void MockMarlin::answer_halted(std::string_view line) {
  if (line == "FIRMWARE_RESTART") return reset();
  const Command command(line);
  if (command.is('M', 105)) return send_ok(" " + temperatures());
  if (command.is('M', 115)) return send_ok(" " + options_.dialect.identity);
  if (!command.is('M', 110) && !line.empty()) tell_halt();
  send_ok("");
}

/// Leaves the command undone.
void MockMarlin::refuse_command(std::string_view why) {
  write_line("!! " + std::string(why));
  tasks_.clear();
}

void MockMarlin::kill(std::string_view reason, std::string_view heater) {
  if (options_.dialect.lives_on)
    return halt_with(std::string(reason) + " (" + std::string(heater) + "), shutdown\n");
  halt_with("Error:" + std::string(reason) + ", system stopped! Heater_ID: " + std::string(heater) +
            "\n\necho:" + std::string(reason) + "\n");
}

void MockMarlin::halt_with(std::string_view first_line) {
  halted_ = true;
  hotend_.set_target(now_, 0);
  bed_.set_target(now_, 0);
  fan_ = 0;
  motion_.quick_stop(now_);
  queue_.clear();
  ring_.clear();
  executing_ = false;
  halt_reason_ = first_line;
  tell_halt();
}

void MockMarlin::tell_halt() {
  const Dialect& d = options_.dialect;
  if (d.lives_on) {
    const std::string_view why = std::string_view(halt_reason_).substr(0, halt_reason_.find('\n'));
    write("// " + std::string(why) + "\n" + d.halted + "!! " + std::string(why) + "\n");
    return;
  }
  write(halt_reason_);
  write(d.halted);
  write(d.power_off);
}

Statistics MockMarlin::statistics() const {
  Statistics s = totals_;
  s.faults = faults_.fired();
  s.motion_s = motion_.moving_seconds();
  s.span_s = motion_.first_start() < 0 ? 0 : motion_.last_end() - motion_.first_start();
  s.blocks = motion_.blocks();
  s.clock_s = now_;
  s.hotend_target = hotend().target();
  s.bed_target = bed().target();
  Heater h = hotend(), b = bed();
  h.update(now_);
  b.update(now_);
  s.hotend = h.temperature();
  s.bed = b.temperature();
  s.fan = fan_;
  s.halted = halted_;
  return s;
}

}  // namespace voidpath::test::mock

#include "tests/mock_printer/mock_marlin.h"

#include <algorithm>
#include <utility>

namespace voidpath::test::mock {
namespace {

constexpr HeaterGuard kHotendGuard{40, 2, 40, 4};
constexpr HeaterGuard kBedGuard{60, 2, 20, 2};

}  // namespace

MockMarlin::MockMarlin(const Options& options)
    : options_(options),
      wire_in_(options.baud, options.round_trip_s / 2),
      wire_out_(options.baud, options.round_trip_s / 2),
      ring_(options.rx_buffer),
      protocol_(options.dialect, options.parenthesis_comments),
      faults_(options.faults, options.seed),
      motion_(options.motion, options.block_buffer),
      hotend_("E0", options.hotend, kHotendGuard),
      bed_("bed", options.bed, kBedGuard) {
  if (options_.dialect.queue > 0) options_.queue = options_.dialect.queue;
  boot();
  fire_due();
}

void MockMarlin::reset() {
  ++totals_.resets;
  boot();
  write(options_.dialect.restarted);
}

void MockMarlin::boot() {
  motion_.quick_stop(now_);
  motion_.settings() = options_.motion;
  hotend_.set_target(now_, 0);
  bed_.set_target(now_, 0);
  ring_.clear();
  unpacker_.reset();
  protocol_.reset();
  queue_.clear();
  tasks_.clear();
  executing_ = halted_ = homed_ = user_wait_ = heat_wait_ = parked_ = tuning_ = false;
  relative_ = relative_e_ = false;
  feed_ = 25;
  feed_factor_ = flow_ = 1;
  fan_ = 0;
  position_ = {};
  motion_.set_position(position_);
  cold_allowed_ = options_.cold_extrusion;
  report_interval_ = 0;
  busy_interval_ = options_.busy_interval_s;
  silent_until_ = -1;
  slow_commands_ = 0;
  emergency_line_.clear();
  boot_until_ = now_ + options_.boot_s;
  next_second_ = next_wait_ = boot_until_ + 1;
  write(options_.dialect.start);
  write(options_.dialect.banner);
}

void MockMarlin::feed(std::string_view bytes) {
  if (options_.baud > 0 || options_.round_trip_s > 0) {
    wire_in_.send(now_, bytes);
    return;
  }
  for (const char byte : bytes) receive(byte);
  process();
}

/// A byte reaches the receive buffer. The firmware's loop is fast: it takes what it can before bytes are
/// lost.
void MockMarlin::receive(char byte) {
  std::string arrived;
  if (faults_.none())
    arrived = byte;
  else
    faults_.pass_byte(byte, false, arrived);
  for (const char c : arrived) {
    if (halted_ && !options_.dialect.lives_on) return;  // deaf until reset
    if (now_ < boot_until_) {
      ++totals_.bytes_dropped;
      continue;
    }
    last_byte_t_ = now_;
    const bool dead = halted_;
    if (options_.emergency_parser || options_.dialect.lives_on) emergency_at(c);
    if (dead || halted_) continue;
    if (ring_.full()) process();
    if (!ring_.push(c)) ++totals_.bytes_dropped;
    // Line by line, so that it makes no difference in what pieces the bytes come.
    if (c == '\n' || c == '\r') process();
  }
}

/// Seen as it arrives, ahead of what waits.
void MockMarlin::emergency_at(char byte) {
  if (byte != '\n' && byte != '\r') {
    if (emergency_line_.size() < kMaxCommandSize) emergency_line_ += byte;
    return;
  }
  const std::string line = std::exchange(emergency_line_, {});
  const std::string_view text = command_text(line);
  if (halted_) return answer_halted(text);
  const bool stop = Command(text).is('M', 112) && queue_.size() < options_.queue;
  if (options_.emergency_parser || (options_.dialect.halts_early && stop)) emergency(text);
}

double MockMarlin::next_event() const {
  double next =
      std::min({wire_in_.next(), wire_out_.next_complete(), motion_.next_event(), faults_.next_time()});
  if (now_ < boot_until_) next = std::min(next, boot_until_);
  if (halted_) return next;
  if (silent_until_ > now_) return std::min(next, silent_until_);
  if (executing_) {
    if (task_until_ >= 0) next = std::min(next, task_until_);
    if (options_.dialect.busy && busy_interval_ > 0 && !tuning_) next = std::min(next, next_busy_);
  }
  if (report_interval_ > 0 && !tuning_) next = std::min(next, next_report_);
  if (hotend().target() > 0 || bed().target() > 0) next = std::min(next, next_second_);
  if (options_.dialect.wait_when_idle && queue_.empty()) next = std::min(next, next_wait_);
  if (misses_line()) next = std::min(next, last_byte_t_ + options_.dialect.asks_again_s);
  return next;
}

// Half a line has come, or one that was asked for has not.
bool MockMarlin::misses_line() const {
  return options_.dialect.asks_again_s > 0 && ring_.empty() && queue_.size() < options_.queue &&
         (protocol_.has_partial() || protocol_.awaits_resend());
}

void MockMarlin::advance_to(double time) {
  for (;;) {
    const double next = next_event();
    if (next > time) break;
    now_ = std::max(now_, next);
    fire_due();
  }
  now_ = std::max(now_, time);
}

/// All that is due at `now_`.
void MockMarlin::fire_due() {
  while (!wire_in_.empty() && wire_in_.next() <= now_) receive(wire_in_.pop());
  for (const Fault& fault : faults_.at_time(now_)) apply(fault);
  motion_.update(now_);
  if (!halted_ && now_ >= boot_until_ && now_ >= silent_until_) {
    tick_second();
    process();
    if (executing_ && options_.dialect.busy && busy_interval_ > 0 && !tuning_ && now_ >= next_busy_) {
      write_line(user_wait_ ? "echo:busy: paused for user" : "echo:busy: processing");
      next_busy_ = now_ + busy_interval_;
    }
    if (report_interval_ > 0 && !tuning_ && now_ >= next_report_) {
      write_line(" " + temperatures());
      next_report_ += report_interval_;
      if (next_report_ <= now_) next_report_ = now_ + report_interval_;
    }
    if (misses_line() && now_ >= last_byte_t_ + options_.dialect.asks_again_s) {
      last_byte_t_ = now_;
      ask_for(protocol_.last_number() + 1);
    }
    if (options_.dialect.wait_when_idle && queue_.empty() && now_ >= next_wait_) {
      write_line("wait");
      next_wait_ = now_ + 1;
    }
  }
  while (!wire_out_.empty() && wire_out_.next() <= now_) ready_out_ += wire_out_.pop();
}

/// The guards over the heaters look once a second.
void MockMarlin::tick_second() {
  if (now_ < next_second_) return;
  next_second_ = now_ + 1;
  for (GuardedHeater* heater : {&hotend_, &bed_})
    if (const auto fault = heater->check(now_)) {
      kill(*fault, heater->id());
      return;
    }
}

void MockMarlin::process() {
  for (;;) {
    if (halted_ || now_ < boot_until_ || now_ < silent_until_) return;
    motion_.update(now_);
    read_lines();
    if (halted_ || now_ < silent_until_) return;
    if (!executing_) {
      if (queue_.empty()) return;
      begin_command();
      if (halted_) return;
    }
    if (!resume()) {
      motion_.update(now_);
      return;
    }
    finish_command();
  }
}

void MockMarlin::read_lines() {
  while (!ring_.empty() && queue_.size() < options_.queue && !halted_ && now_ >= silent_until_) {
    const char byte = ring_.pop();
    if (!options_.meatpack) {
      read_character(byte);
      continue;
    }
    std::string characters;
    bool told = false;
    unpacker_.take(byte, characters, told);
    if (told) write_line(unpacker_.state());
    for (const char c : characters) read_character(c);
  }
}

void MockMarlin::read_character(char byte) {
  if (byte == '\n' || byte == '\r')
    handle_line_end(byte);
  else if (auto result = protocol_.take(byte))
    handle_result(*result);
}

void MockMarlin::handle_line_end(char byte) {
  bool again = false;
  const std::string raw = protocol_.partial();
  if (!raw.empty()) {
    ++totals_.lines;
    if (!faults_.none()) {
      for (const Fault& fault : faults_.at_line()) {
        if (fault.kind == FaultKind::kDropLine) {
          protocol_.drop_partial();
        } else if (fault.kind == FaultKind::kGarbleLine) {
          std::string& line = protocol_.partial();
          if (!line.empty()) {
            char& hit = line[faults_.pick(line.size())];
            hit = static_cast<char>(hit ^ (1 << faults_.pick(7)));
          }
        } else if (fault.kind == FaultKind::kDoubleLine) {
          again = true;
        } else if (fault.kind == FaultKind::kSpuriousResend) {
          refuse({options_.dialect.wrong_checksum + std::to_string(protocol_.last_number()),
                  protocol_.last_number() + 1});
          return;
        } else {
          apply(fault);
          if (halted_ || now_ < boot_until_ || protocol_.partial().empty()) return;
        }
      }
    }
  }
  if (auto result = protocol_.take(byte)) handle_result(*result);
  if (!again) return;
  for (const char c : raw) protocol_.take(c);
  if (auto result = protocol_.take(byte)) handle_result(*result);
}

void MockMarlin::handle_result(const LineResult& result) {
  if (const auto* refused = std::get_if<RefusedLine>(&result)) {
    refuse(*refused);
  } else if (const auto* ignored = std::get_if<IgnoredLine>(&result)) {
    if (ignored->blank && options_.dialect.blank_ok) send_ok("");
  } else if (const auto* skipped = std::get_if<SkippedLine>(&result)) {
    write_line("skip " + std::to_string(skipped->number));
    send_ok("");
  } else {
    const auto& accepted = std::get<AcceptedLine>(result);
    if (accepted_) accepted_(accepted.text, accepted.number);
    // Without an emergency parser these act when they are read, if they came without a number.
    if (!options_.emergency_parser && !accepted.number && options_.dialect.commands.empty())
      emergency(accepted.text);
    if (halted_) return;
    queue_.push_back({accepted.text, accepted.number, false});
    if (options_.dialect.ok_at_enqueue) send_ok("");
  }
}

void MockMarlin::emergency(std::string_view line) {
  const Command command(line);
  if (command.is('M', 112)) {
    ++totals_.commands;
    if (log_) log_(command.text());
    halt_with(options_.dialect.stopped);
  } else if (command.is('M', 108)) {
    heat_wait_ = user_wait_ = false;
  } else if (command.is('M', 876) && options_.emergency_parser) {
    user_wait_ = false;
  } else if (command.is('M', 410)) {
    quick_stop();
  }
}

/// Motion ends here and now; what the executing command still wanted to move is forgotten with it.
void MockMarlin::quick_stop() {
  motion_.quick_stop(now_);
  position_ = motion_.planner().position();
  for (std::size_t i = task_; i < tasks_.size(); ++i)
    if (tasks_[i].kind == Task::Kind::kMove) tasks_[i] = {.kind = Task::Kind::kCall};
}

void MockMarlin::begin_command() {
  executing_ = true;
  ok_tail_.clear();
  tasks_.clear();
  task_ = 0;
  task_until_ = -1;
  next_busy_ = now_ + busy_interval_;
  if (slow_commands_ > 0) {
    --slow_commands_;
    tasks_.push_back({.kind = Task::Kind::kDwell, .seconds = slow_s_});
  }
  const Command command(queue_.front().text);
  if (!queue_.front().own) {
    ++totals_.commands;
    if (log_) log_(command.text());
  }
  execute(command);
}

bool MockMarlin::resume() {
  for (; task_ < tasks_.size(); ++task_) {
    if (!task_done(tasks_[task_])) return false;
    task_until_ = -1;
  }
  return true;
}

bool MockMarlin::task_done(Task& task) {
  switch (task.kind) {
    case Task::Kind::kMove:
      if (options_.instant_moves) return true;
      if (motion_.full()) return false;
      motion_.add_move(now_, task.target, segment_feed_, flow_);
      motion_.update(now_);
      return true;
    case Task::Kind::kDrained:
      return motion_.drained();
    case Task::Kind::kDwell:
      if (task_until_ < 0) {
        task_until_ = now_ + task.seconds;
        if (task.account != nullptr) *task.account += task.seconds;
      }
      return now_ >= task_until_;
    case Task::Kind::kHeat: {
      Heater& heater = task.heat->bed() ? bed_.heater() : hotend_.heater();
      heater.update(now_);
      if (!heat_wait_ || task.heat->over(now_, heater)) {
        heat_wait_ = false;
        return true;
      }
      if (now_ >= task_until_) {
        if (task_until_ >= 0) {
          const Dialect& dialect = options_.dialect;
          write_line((dialect.bare_temperatures ? "" : " ") + temperatures() +
                     (dialect.tells_wait ? task.heat->countdown(now_) : ""));
          totals_.heating_s += 1;
        }
        task_until_ = now_ + 1;
      }
      task_until_ = std::min(task_until_, task.heat->done_at());
      return false;
    }
    case Task::Kind::kUser:
      return !user_wait_;
    case Task::Kind::kCall:
      if (task.action) task.action();
      return true;
  }
  return true;
}

void MockMarlin::finish_command() {
  executing_ = false;
  task_until_ = -1;
  const Queued done = queue_.front();
  queue_.pop_front();
  if (options_.dialect.ok_at_enqueue) {
    if (!ok_tail_.empty()) write_line(ok_tail_.substr(1));
  } else if (!done.own) {
    if (ok_tail_.empty() && options_.advanced_ok)
      send_ok((done.number ? " N" + std::to_string(*done.number) : std::string()) + free_slots());
    else
      send_ok(ok_tail_);
  }
  next_wait_ = now_ + 1;
}

bool MockMarlin::waits_for_host() const {
  return !halted_ && now_ >= boot_until_ && now_ >= silent_until_ && queue_.empty() && ring_.empty() &&
         wire_in_.empty() && wire_out_.empty() && !motion_.full();
}

}  // namespace voidpath::test::mock

#include "tests/mock_printer/mock_s3g.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace voidpath::test::mock {
namespace {

constexpr HeaterGuard kHotendGuard{40, 2, 40, 4};
constexpr HeaterGuard kBedGuard{60, 2, 20, 2};
/// A packet that does not go on for so long is given up, s.
constexpr double kPacketTimeout = 0.2;
constexpr std::size_t kLongestPacket = 32;
/// A cancelled build is at rest after so long, s.
constexpr double kHeadLeaves_s = 2;
/// So much later than its original a doubled reply sets out, s: the next packet is under way then.
constexpr double kCopyDelay = 0.0004;
constexpr double kBitsPerByte = 10;  ///< 8N1
/// A heater this near its target counts as there, °C.
constexpr double kReached = 2;

/// One bit after the other, as in the definition.
unsigned checksum(std::string_view bytes) {
  unsigned crc = 0;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int i = 0; i < 8; ++i) crc = (crc & 1U) != 0 ? (crc >> 1) ^ 0x8CU : crc >> 1;
  }
  return crc;
}

std::string number(std::uint32_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i));
  return out;
}

std::string byte(unsigned value) { return std::string(1, static_cast<char>(value)); }

}  // namespace

MockS3g::MockS3g(const S3gOptions& options)
    : options_(options),
      wire_in_(options.baud, options.round_trip_s / 2),
      wire_out_(options.baud, options.round_trip_s / 2 + options.turnaround_s),
      faults_(options.faults, options.seed),
      motion_(options.motion, options.block_buffer),
      bed_("bed", options.bed, kBedGuard) {
  for (int i = 0; i < 2; ++i) hotends_.emplace_back("T" + std::to_string(i), options.hotend, kHotendGuard);
  reset();
  totals_.resets = 0;
}

void MockS3g::reset() {
  ++totals_.resets;
  stop_all();
  forget_packet();
  line_ = 0;
  tool_ = 0;
  build_ = 0;
  paused_ = cancel_note_ = heat_shutdown_ = false;
  position_ = {};
  motion_.set_position(position_mm());
  motion_.align_steps();
  silent_until_ = busy_until_ = resume_at_ = cancelled_at_ = -1;
  slow_commands_ = 0;
  boot_until_ = now_ + options_.boot_s;
  next_second_ = boot_until_ + 1;
}

/// Motors, queue and heaters.
void MockS3g::stop_all() {
  queue_.clear();
  queue_bytes_ = 0;
  card_ = false;
  motion_.quick_stop(now_);
  const Axes mm = motion_.planner().position();
  for (std::size_t i = 0; i < 3; ++i)
    position_[i] = static_cast<std::int32_t>(std::lround(mm[i] * options_.motion.steps_per_mm[i]));
  mode_ = Mode::ready;
  until_ = -1;
  for (GuardedHeater& hotend : hotends_) hotend.set_target(now_, 0);
  bed_.set_target(now_, 0);
}

void MockS3g::feed(std::string_view bytes) {
  if (options_.baud > 0 || options_.round_trip_s > 0) {
    wire_in_.send(now_, bytes);
    return;
  }
  for (const char c : bytes) receive(c);
  run_queue();
}

void MockS3g::receive(char c) {
  std::string arrived;
  faults_.pass_byte(c, false, arrived);
  for (const char one : arrived) {
    if (now_ < boot_until_ || now_ < silent_until_) {
      ++totals_.bytes_dropped;
      continue;
    }
    packet_byte(one);
    look_at_packet();
  }
}

void MockS3g::packet_byte(char c) {
  const auto value = static_cast<unsigned char>(c);
  switch (packet_state_) {
    case Reading::start:
      if (value != 0xD5) return refuse_packet(0);
      packet_state_ = Reading::length;
      packet_begun_ = now_;
      return;
    case Reading::length:
      if (value > kLongestPacket) return refuse_packet(4);
      packet_length_ = value;
      packet_.clear();
      packet_state_ = value > 0 ? Reading::payload : Reading::crc;
      return;
    case Reading::payload:
      packet_ += c;
      if (packet_.size() == packet_length_) packet_state_ = Reading::crc;
      return;
    case Reading::crc:
      ++totals_.lines;
      if (value != checksum(packet_)) {
        ++totals_.resends;
        return refuse_packet(3);
      }
      packet_state_ = Reading::done;
      return;
    case Reading::done:
      return;
  }
}

void MockS3g::refuse_packet(unsigned code) {
  packet_error_ = code;
  packet_state_ = Reading::start;
}

void MockS3g::forget_packet() {
  packet_error_.reset();
  packet_state_ = Reading::start;
}

/// What has been read is looked at only while no reply is being sent. An error forgets the packet in
/// progress, even one that began behind it.
void MockS3g::look_at_packet() {
  if (now_ < sending_until_) return;
  if (packet_error_) {
    const unsigned code = *packet_error_;
    forget_packet();
    reply_code(code);
  } else if (packet_state_ == Reading::done) {
    packet_state_ = Reading::start;
    handle_packet(std::string(packet_));
  }
}

void MockS3g::handle_packet(const std::string& payload) {
  if (!faults_.none()) {
    for (const Fault& fault : faults_.at_line()) {
      if (fault.kind == FaultKind::kDropLine) return;
      if (fault.kind == FaultKind::kGarbleLine) {
        ++totals_.resends;
        return reply_code(3);
      }
      apply(fault);
      if (now_ < silent_until_ || now_ < boot_until_) return;
    }
  }
  if (cancel_note_) {
    cancel_note_ = false;
    return reply_code(9);
  }
  if (heat_shutdown_) return reply_code(0x0B);
  if (payload.empty()) return reply_code(5);
  if (static_cast<unsigned char>(payload[0]) < 128) {
    answer_query(payload);
  } else {
    take_action(payload);
  }
  run_queue();
}

void MockS3g::take_action(const std::string& payload) {
  if (card_ || now_ < busy_until_) return reply_code(0x0A);
  if (queue_bytes_ + payload.size() > options_.queue_bytes) return reply_code(2);
  queue_.push_back(payload);
  queue_bytes_ += payload.size();
  reply_code(1);
}

std::string MockS3g::tool_answer(const std::string& payload) const {
  if (payload.size() < 3) return byte(0x84);
  const auto tool = static_cast<unsigned char>(payload[1]);
  if (tool >= options_.tools) return byte(0x87);
  const Heater& hotend = hotends_[tool].heater();
  const Heater& bed = bed_.heater();
  const auto whole = [](double v) { return number(static_cast<std::uint32_t>(std::lround(v)), 2); };
  const auto ready = [](const Heater& heater) {
    return byte(heater.target() <= 0 || std::abs(heater.target() - heater.temperature()) <= kReached);
  };
  switch (static_cast<unsigned char>(payload[2])) {
    case 2:
      return byte(0x81) + whole(hotend.temperature());
    case 22:
      return byte(0x81) + ready(hotend);
    case 30:
      return byte(0x81) + whole(bed.temperature());
    case 32:
      return byte(0x81) + whole(hotend.target());
    case 33:
      return byte(0x81) + whole(bed.target());
    case 35:
      return byte(0x81) + ready(bed);
    default:
      return byte(0x85);
  }
}

void MockS3g::answer_query(const std::string& payload) {
  for (GuardedHeater& hotend : hotends_) hotend.heater().update(now_);
  bed_.heater().update(now_);
  const std::string ok = byte(0x81);
  switch (static_cast<unsigned char>(payload[0])) {
    case 0:
      if (payload.size() != 3) return reply_code(0);
      return reply(ok + number(707, 2));
    case 2:
      return reply(ok + number(static_cast<std::uint32_t>(options_.queue_bytes - queue_bytes_), 4));
    case 3:
    case 7:
    case 17: {
      ++aborts_;
      reply(ok);
      // One that is paused counts it as a cancel, of which it tells as well; one that runs begins a cancel
      // and never ends it. Other builds are remembered.
      const unsigned build = build_;
      reset();
      cancel_note_ = build == 3;
      build_ = build == 3 ? 4 : build == 1 ? 5 : build;
      return;
    }
    case 8:
      toggle_pause();
      return reply(ok);
    case 10:
      return reply(tool_answer(payload));
    case 11:
      return reply(ok + byte(queue_.empty() && drained() && !card_));
    case 21: {
      if (!options_.tells_position) return reply_code(5);
      std::string out = ok;
      std::array<std::int32_t, 5> at = position_;
      const auto moving = motion_.steps_at(now_);
      for (std::size_t i = 0; i < 3 && !motion_.drained(); ++i) at[i] = static_cast<std::int32_t>(moving[i]);
      for (const std::int32_t steps : at) out += number(static_cast<std::uint32_t>(steps), 4);
      return reply(out + number(0, 2));
    }
    case 22: {
      const auto what = payload.size() > 1 ? static_cast<unsigned char>(payload[1]) : 0U;
      // A pause ends with the queue, though the state still tells of it.
      if ((what & 2U) != 0) queue_.clear(), queue_bytes_ = 0, paused_ = false;
      if ((what & 1U) != 0) {
        motion_.quick_stop(now_);
        const Axes mm = motion_.planner().position();
        for (std::size_t i = 0; i < 3; ++i)
          position_[i] = static_cast<std::int32_t>(std::lround(mm[i] * options_.motion.steps_per_mm[i]));
        mode_ = Mode::ready;
        until_ = -1;
      }
      return reply(ok + byte(0));
    }
    case 23:
      return reply(ok + byte(heat_shutdown_ ? 0x40 : cancelled_at_ >= 0 ? 0x20 : 0));
    case 24:
      return reply(ok + byte(build_) + byte(0) + byte(0) + number(options_.counts_lines ? line_ : 0, 4) +
                   number(0, 4));
    case 27:
      if (!options_.advanced_version) return reply_code(5);
      if (payload.size() != 3) return reply_code(0);
      return reply(ok + number(707, 2) + number(0, 2) + byte(0x80) + byte(0) + number(0, 2));
    default:
      return reply_code(5);
  }
}

/// A reply on its way back, through what may befall it.
void MockS3g::reply(std::string_view payload) {
  std::string framed = byte(0xD5) + byte(static_cast<unsigned>(payload.size())) + std::string(payload) +
                       byte(checksum(payload));
  std::string copy;
  if (options_.baud > 0)
    sending_until_ = now_ + kBitsPerByte / options_.baud * static_cast<double>(framed.size());
  if (!faults_.none()) {
    for (const Fault& fault : faults_.at_ok()) {
      if (fault.kind == FaultKind::kLoseOk) {
        framed.clear();
      } else if (fault.kind == FaultKind::kDoubleOk) {
        copy = framed;
      } else if (fault.kind == FaultKind::kGarbleOk && !framed.empty()) {
        char& hit = framed[faults_.pick(framed.size())];
        hit = static_cast<char>(hit ^ (1 << faults_.pick(8)));
      } else {
        apply(fault);
      }
    }
    std::string out;
    for (const char c : framed) faults_.pass_byte(c, true, out);
    framed = std::move(out);
  }
  if (options_.baud > 0 || options_.round_trip_s > 0 || options_.turnaround_s > 0) {
    wire_out_.send(now_, framed);
    wire_out_.send(now_ + kCopyDelay, copy);
  } else {
    ready_out_ += framed + copy;
  }
}

void MockS3g::apply(const Fault& fault) {
  switch (fault.kind) {
    case FaultKind::kReset:
      return reset();
    case FaultKind::kHalt:
      return shut_heaters_down();
    case FaultKind::kUnplug:
      unplug_ = fault.seconds;
      return;
    case FaultKind::kSilence:
      silent_until_ = now_ + fault.seconds;
      forget_packet();
      return;
    case FaultKind::kSlow:
      slow_commands_ = fault.lines;
      slow_s_ = fault.seconds;
      return;
    case FaultKind::kDeadHeater:
      (fault.heater == "bed" ? bed_ : hotends_[0]).heater().break_element();
      return;
    case FaultKind::kPause:
      if (!paused_) press_pause();
      resume_at_ = now_ + fault.seconds;
      return;
    case FaultKind::kCancel:
      return cancel_at_panel();
    case FaultKind::kBusy:
      return print_from_card(fault.seconds);
    default:
      return;
  }
}

// None can be chosen while another print runs: then only the host is refused.
void MockS3g::print_from_card(double seconds) {
  busy_until_ = now_ + seconds;
  if (build_ == 1 || build_ == 3 || !queue_.empty() || !drained()) return;
  card_ = true;
  build_ = 1;
  run_queue();
}

// The panel offers it during a print...
void MockS3g::press_pause() {
  if (build_ == 1 || build_ == 3) toggle_pause();
}

// ...the host may send it at any time, and is obeyed.
void MockS3g::toggle_pause() {
  if (cancelled_at_ >= 0) return;
  paused_ = !paused_;
  build_ = paused_ ? 3 : 1;
}

void MockS3g::shut_heaters_down() {
  stop_all();
  heat_shutdown_ = cancel_note_ = true;
}

/// What runs is first paused, until the head has left the part. What the host sends meanwhile is accepted,
/// and forgotten with the rest.
void MockS3g::cancel_at_panel() {
  if (cancelled_at_ >= 0) return;
  if (build_ != 1) return end_cancel();
  motion_.quick_stop(now_);
  paused_ = true;
  build_ = 5;
  cancelled_at_ = now_ + kHeadLeaves_s;
}

void MockS3g::end_cancel() {
  stop_all();
  paused_ = false;
  cancelled_at_ = -1;
  build_ = 4;
  cancel_note_ = true;
}

double MockS3g::next_event() const {
  double next =
      std::min({wire_in_.next(), wire_out_.next_complete(), motion_.next_event(), faults_.next_time()});
  if (now_ < boot_until_) next = std::min(next, boot_until_);
  if (silent_until_ > now_) next = std::min(next, silent_until_);
  if (is_reading()) next = std::min(next, packet_begun_ + kPacketTimeout);
  if (packet_error_ || packet_state_ == Reading::done) next = std::min(next, sending_until_);
  const bool runs = !paused_ && !heat_shutdown_ && now_ >= boot_until_ && now_ >= silent_until_;
  if (until_ >= 0 && runs) next = std::min(next, until_);
  if (resume_at_ >= 0) next = std::min(next, resume_at_);
  if (cancelled_at_ >= 0) next = std::min(next, cancelled_at_);
  if (card_ && busy_until_ > now_) next = std::min(next, busy_until_);
  bool heats = bed_.heater().target() > 0;
  for (const GuardedHeater& hotend : hotends_) heats = heats || hotend.heater().target() > 0;
  if (heats) next = std::min(next, next_second_);
  return next;
}

void MockS3g::advance_to(double time) {
  for (;;) {
    const double next = next_event();
    if (next > time) break;
    now_ = std::max(now_, next);
    fire_due();
  }
  now_ = std::max(now_, time);
}

void MockS3g::fire_due() {
  if (is_reading() && now_ >= packet_begun_ + kPacketTimeout) refuse_packet(0x0C);
  look_at_packet();
  while (!wire_in_.empty() && wire_in_.next() <= now_) receive(wire_in_.pop());
  for (const Fault& fault : faults_.at_time(now_)) apply(fault);
  motion_.update(now_);
  if (cancelled_at_ >= 0 && now_ >= cancelled_at_) end_cancel();
  if (resume_at_ >= 0 && now_ >= resume_at_) {
    resume_at_ = -1;
    if (paused_) press_pause();
  }
  if (now_ >= boot_until_) {
    tick_second();
    run_queue();
  }
  while (!wire_out_.empty() && wire_out_.next() <= now_) ready_out_ += wire_out_.pop();
}

/// The guards over the heaters look once a second.
void MockS3g::tick_second() {
  if (now_ < next_second_) return;
  next_second_ = now_ + 1;
  bool failed = bed_.check(now_).has_value();
  for (GuardedHeater& hotend : hotends_) failed = hotend.check(now_).has_value() || failed;
  if (failed) shut_heaters_down();
}

std::string MockS3g::take_output() { return std::exchange(ready_out_, {}); }
std::optional<double> MockS3g::take_unplug() { return std::exchange(unplug_, {}); }

bool MockS3g::waits_for_host() const {
  if (now_ < boot_until_ || now_ < silent_until_) return false;
  if (is_reading() || packet_error_ || packet_state_ == Reading::done) return false;
  if (!wire_in_.empty() || !wire_out_.empty() || !ready_out_.empty()) return false;
  // With a full queue or a command that takes its time, more input would change nothing.
  return mode_ == Mode::ready && !paused_ && !card_ && queue_.empty() && !motion_.full();
}

Statistics MockS3g::statistics() const {
  Statistics s = totals_;
  s.commands = executed_;
  s.faults = faults_.fired();
  s.unknown = violations_.size();
  s.motion_s += motion_.moving_seconds();
  s.span_s = motion_.first_start() < 0 ? 0 : motion_.last_end() - motion_.first_start();
  s.clock_s = now_;
  s.blocks = motion_.blocks();
  s.hotend_target = hotends_[0].heater().target();
  s.hotend = hotends_[0].heater().temperature();
  s.bed_target = bed_.heater().target();
  s.bed = bed_.heater().temperature();
  s.fan = fan_;
  s.halted = heat_shutdown_;
  return s;
}

}  // namespace voidpath::test::mock

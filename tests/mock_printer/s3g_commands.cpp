// What the commands of the queue do.

#include "tests/mock_printer/mock_s3g.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace voidpath::test::mock {
namespace {

constexpr double kReached = 2;
constexpr double kLookAgain = 0.1;
constexpr const char* kNames = "XYZAB";

std::uint32_t unsigned_at(const std::string& payload, std::size_t at, std::size_t bytes) {
  std::uint32_t out = 0;
  for (std::size_t i = bytes; i-- > 0;) out = out << 8 | static_cast<unsigned char>(payload.at(at + i));
  return out;
}
std::int32_t signed_at(const std::string& payload, std::size_t at) {
  return static_cast<std::int32_t>(unsigned_at(payload, at, 4));
}
unsigned byte_at(const std::string& payload, std::size_t at) {
  return static_cast<unsigned char>(payload.at(at));
}

/// Bytes of a command; 0: it has a text or a length of its own.
std::size_t length_of(unsigned code) {
  switch (code) {
    case 131:
    case 132:
      return 8;
    case 133:
      return 5;
    case 134:
    case 137:
    case 143:
    case 144:
    case 151:
    case 152:
    case 154:
    case 156:
      return 2;
    case 135:
    case 141:
    case 146:
    case 147:
      return 6;
    case 139:
      return 25;
    case 140:
      return 21;
    case 142:
      return 26;
    case 145:
    case 150:
      return 3;
    case 148:
    case 158:
      return 5;
    case 155:
      return 32;
    case 157:
      return 21;
    default:
      return 0;
  }
}

std::string axes_text(unsigned mask) {
  std::string out;
  for (unsigned i = 0; i < 5; ++i)
    if ((mask >> i & 1U) != 0) out += std::string(" ") + kNames[i];
  return out;
}

}  // namespace

void MockS3g::say(const std::string& line) {
  if (log_) log_(line);
}

void MockS3g::violate(const std::string& what) {
  violations_.push_back(what);
  say("; violation: " + what);
}

Axes MockS3g::position_mm() const {
  Axes mm{};
  for (std::size_t i = 0; i < 3; ++i) mm[i] = position_[i] / options_.motion.steps_per_mm[i];
  // The two extruders are one axis to the planner: never do both move at once. Forward is down.
  mm[kE] = -(position_[3] + position_[4]) / options_.motion.steps_per_mm[kE];
  return mm;
}

/// Commands that begin only when the motors stand still.
bool MockS3g::needs_rest(unsigned code) const {
  switch (code) {
    case 131:
    case 132:
    case 133:
    case 134:
    case 135:
    case 139:
    case 140:
    case 141:
    case 143:
    case 144:
      return true;
    default:
      return false;
  }
}

void MockS3g::run_queue() {
  for (;;) {
    if (paused_ || heat_shutdown_ || now_ < boot_until_ || now_ < silent_until_) return;
    motion_.update(now_);
    if (card_) return run_card();
    if (mode_ == Mode::timed) {
      if (now_ < until_) return;
      mode_ = Mode::ready;
      until_ = -1;
    } else if (mode_ != Mode::ready) {
      GuardedHeater& guarded =
          mode_ == Mode::wait_bed ? bed_ : hotends_[static_cast<std::size_t>(waiting_tool_)];
      Heater& heater = guarded.heater();
      heater.update(now_);
      if (heater.target() > 0 && heater.temperature() < heater.target() - kReached) {
        if (now_ >= until_) until_ = now_ + kLookAgain, totals_.heating_s += kLookAgain;
        return;
      }
      mode_ = Mode::ready;
      until_ = -1;
    }
    if (queue_.empty()) return;
    const std::string& front = queue_.front();
    const unsigned code = byte_at(front, 0);
    const bool is_move = code == 142 || code == 155;
    if (is_move && motion_.full()) return;
    if (needs_rest(code) && !motion_.drained()) return;
    if (slow_commands_ > 0) {
      --slow_commands_;
      mode_ = Mode::timed;
      until_ = now_ + slow_s_;
      return;
    }
    const std::string payload = front;
    queue_.pop_front();
    queue_bytes_ -= payload.size();
    // Like the real one, it forgets to count motors switched while others run.
    if (code != 137 || motion_.drained()) ++line_;
    ++executed_;
    if (payloads_) payloads_(payload);
    begin(payload);
  }
}

/// To and fro, as long as the print from the card goes on.
void MockS3g::run_card() {
  if (now_ >= busy_until_) {
    if (!motion_.drained()) return;
    card_ = false;
    build_ = 2;
    return;
  }
  constexpr double kStroke_mm = 20, kFeed_mm_s = 40;
  const auto stroke = static_cast<std::int32_t>(kStroke_mm * options_.motion.steps_per_mm[kX]);
  while (!motion_.full()) {
    position_[kX] += position_[kX] > 0 ? -stroke : stroke;
    motion_.add_move(now_, position_mm(), kFeed_mm_s, 1);
    motion_.update(now_);
  }
}

bool MockS3g::has_right_length(const std::string& payload) {
  const unsigned code = byte_at(payload, 0);
  std::size_t length = length_of(code);
  if (code == 136) length = payload.size() < 5 ? 5 : byte_at(payload, 3) + std::size_t{4};
  if ((code == 149 || code == 153) && payload.size() < 6) length = 6;
  if (length == 0 || length == payload.size()) return true;
  violate("command " + std::to_string(code) + " of " + std::to_string(payload.size()) + " bytes");
  return false;
}

void MockS3g::timed(double seconds, double& account) {
  mode_ = Mode::timed;
  until_ = now_ + seconds;
  account += seconds;
}

void MockS3g::begin(const std::string& p) {
  const unsigned code = byte_at(p, 0);
  if (!has_right_length(p)) return;
  switch (code) {
    case 131:
    case 132:
      home(p);
      return;
    case 133:
      say("G4 P" + std::to_string(unsigned_at(p, 1, 4)));
      timed(unsigned_at(p, 1, 4) / 1000.0, totals_.dwell_s);
      return;
    case 134:
      if (byte_at(p, 1) >= static_cast<unsigned>(options_.tools)) violate("a tool that is not there");
      tool_ = byte_at(p, 1);
      say("T" + std::to_string(tool_));
      return;
    case 135:
    case 141:
      if (code == 135 && byte_at(p, 1) >= static_cast<unsigned>(options_.tools))
        violate("a tool that is not there");
      if (code == 141 && !options_.heated_bed) violate("a bed that does not heat");
      say(code == 135 ? "M133 T" + std::to_string(byte_at(p, 1)) : "M134");
      waiting_tool_ = static_cast<int>(std::min(byte_at(p, 1), 1U));
      mode_ = code == 135 ? Mode::wait_tool : Mode::wait_bed;
      until_ = now_;
      return;
    case 136:
      tool_action(p);
      return;
    case 137:
      say(((byte_at(p, 1) & 0x80U) != 0 ? "M17" : "M18") + axes_text(byte_at(p, 1)));
      return;
    case 139:
      raw_move(p);
      return;
    case 140:
      for (std::size_t i = 0; i < 5; ++i) position_[i] = signed_at(p, 1 + 4 * i);
      motion_.set_position(position_mm());
      motion_.align_steps();
      say("G92");
      return;
    case 142:
    case 155:
      return move(p);
    case 144:
      for (std::size_t i = 0; i < 5; ++i)
        if ((byte_at(p, 1) >> i & 1U) != 0) position_[i] = options_.home[i];
      motion_.set_position(position_mm());
      motion_.align_steps();
      say("M132" + axes_text(byte_at(p, 1)));
      return;
    case 145:
      if (byte_at(p, 1) > 4 || byte_at(p, 2) > 127) violate("a potentiometer out of range");
      say("G130 " + std::string(1, kNames[std::min(byte_at(p, 1), 4U)]) + std::to_string(byte_at(p, 2)));
      return;
    case 149:
    case 153:
      if (p.back() != '\0') violate("a text without end");
      if (code == 153) line_ = 0, build_ = 1;
      say(code == 153 ? "M136 " + p.substr(5, p.size() - 6) : "M70 " + p.substr(5, p.size() - 6));
      return;
    case 150:
      if (byte_at(p, 1) > 100) violate("more than 100 percent");
      say("M73 P" + std::to_string(byte_at(p, 1)));
      return;
    case 154:
      build_ = 2;
      say("M137");
      return;
    case 143:
    case 146:
    case 147:
    case 148:
    case 151:
    case 156:
    case 158:
      say("; command " + std::to_string(code));
      return;
    default:
      violate("unknown command " + std::to_string(code));
      return;
  }
}

void MockS3g::home(const std::string& p) {
  const bool to_max = byte_at(p, 0) == 132;
  const unsigned axes = byte_at(p, 1);
  if ((to_max && (axes & 4U) != 0) || (!to_max && (axes & 3U) != 0)) violate("homing against the frame");
  if (unsigned_at(p, 2, 4) == 0 || unsigned_at(p, 6, 2) == 0) violate("homing at no speed or for no time");
  say((to_max ? "G162" : "G161") + axes_text(axes));
  // All together, each at the told time a step, until it meets its switch.
  double steps = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((axes >> i & 1U) == 0) continue;
    steps = std::max(steps, std::abs(static_cast<double>(options_.home[i] - position_[i])));
    position_[i] = options_.home[i];
  }
  motion_.set_position(position_mm());
  motion_.align_steps();
  timed(steps * unsigned_at(p, 2, 4) / 1e6, totals_.homing_s);
}

void MockS3g::tool_action(const std::string& p) {
  const unsigned tool = byte_at(p, 1), command = byte_at(p, 2);
  if (tool >= static_cast<unsigned>(options_.tools)) return violate("a tool that is not there");
  if ((command == 3 || command == 31) && p.size() != 6) return violate("a temperature without its two bytes");
  if (command == 3) {
    hotends_[tool].set_target(now_, unsigned_at(p, 4, 2));
    say("M104 T" + std::to_string(tool) + " S" + std::to_string(unsigned_at(p, 4, 2)));
  } else if (command == 31) {
    if (!options_.heated_bed) violate("a bed that does not heat");
    bed_.set_target(now_, unsigned_at(p, 4, 2));
    say("M140 S" + std::to_string(unsigned_at(p, 4, 2)));
  } else if (command == 12 || command == 13) {
    fan_ = byte_at(p, 4);
    say(byte_at(p, 4) != 0 ? "M126" : "M127");
  } else {
    violate("unknown tool command " + std::to_string(command));
  }
}

/// 155: accelerated, with length and speed as told.
void MockS3g::move(const std::string& p) {
  const bool accelerated = byte_at(p, 0) == 155;
  const unsigned mask = byte_at(p, 25);
  std::array<std::int32_t, 5> target{};
  double squares = 0, extruded = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    const std::int32_t value = signed_at(p, 1 + 4 * i);
    target[i] = (mask >> i & 1U) != 0 ? position_[i] + value : value;
    const double mm = (target[i] - position_[i]) / options_.motion.steps_per_mm[std::min(i, kE)];
    if (i < 3) squares += mm * mm;
    if (i >= 3) extruded += std::abs(mm);
  }
  if (target[4] != position_[4] && options_.tools < 2) violate("a second extruder that is not there");
  if (options_.tools > 1 && target[4 - tool_ % 2] != position_[4 - tool_ % 2])
    violate("filament of another tool than the chosen one");
  position_ = target;
  double feed = 0;
  const double length = squares > 0 ? std::sqrt(squares) : extruded;
  if (accelerated) {
    const double told = static_cast<double>(std::bit_cast<float>(unsigned_at(p, 26, 4)));
    feed = unsigned_at(p, 30, 2) / 64.0;
    if (std::abs(told - length) > 1e-3 * length + 1e-4) violate("a move of another length than told");
    if (unsigned_at(p, 21, 4) == 0 || !(feed > 0)) violate("a move at no speed");
  } else {
    feed = length / (std::max(unsigned_at(p, 21, 4), 1U) / 1e6);
  }
  const Axes mm = position_mm();
  char text[160];
  std::snprintf(text, sizeof text, "G1 X%.3f Y%.3f Z%.3f A%.4f F%.1f", mm[kX], mm[kY], mm[kZ], mm[kE],
                feed * 60);
  say(text);
  motion_.add_move(now_, mm, feed, 1);
  motion_.update(now_);
}

/// 139: no acceleration, every step of the longest axis after the same time.
void MockS3g::raw_move(const std::string& p) {
  std::int32_t most = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    most = std::max(most, std::abs(signed_at(p, 1 + 4 * i) - position_[i]));
    position_[i] = signed_at(p, 1 + 4 * i);
  }
  motion_.set_position(position_mm());
  motion_.align_steps();
  const Axes mm = position_mm();
  char text[160];
  std::snprintf(text, sizeof text, "G0 X%.3f Y%.3f Z%.3f A%.4f", mm[kX], mm[kY], mm[kZ], mm[kE]);
  say(text);
  timed(most * (unsigned_at(p, 21, 4) / 1e6), totals_.motion_s);
}

}  // namespace voidpath::test::mock

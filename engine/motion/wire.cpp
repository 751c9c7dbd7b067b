#include "engine/motion/wire.h"

#include <algorithm>

namespace voidpath::motion {
namespace {

constexpr double kBitsPerByte = 10;  // start, eight, stop
/// 'N', '*', newline, and a checksum that mostly has two digits.
constexpr std::size_t kFrameBytes = 5;
/// What MeatPack packs, in its mode without blanks; of the frame all but 'N' and '*'.
constexpr std::string_view kCommon = "0123456789.E\nGX";
constexpr std::size_t kRareInFrame = 2;
/// A packed character, and one that is not: half a byte that says so, and its own.
constexpr std::size_t kCommonBits = 4, kRareBits = 12;
/// Lines between looks whether both planners plan alike again.
constexpr std::size_t kJoinEvery = 8;

/// S3G: a move is 32 bytes of the firmware's queue; on the wire three more, and four of reply, and the host's
/// turn-round: only then may the next one go.
constexpr std::size_t kS3gMove = 32;
constexpr double kS3gWireBytes = 39;
constexpr double kS3gTurnRound_t = 0.001;

/// The rate at which queue bytes come in.
double line_rate(const MachineLimits& limits) {
  if (limits.firmware != Firmware::s3g || limits.baud <= 0) return limits.baud;
  const double move_t = kS3gWireBytes * kBitsPerByte / limits.baud + kS3gTurnRound_t;
  return kS3gMove * kBitsPerByte / move_t;
}

std::size_t digits(std::size_t n) {
  std::size_t count = 1;
  for (; n >= 10; n /= 10) ++count;
  return count;
}

}  // namespace

SerialLine::SerialLine(double baud, int rx_bytes)
    : byte_t_(baud > 0 ? kBitsPerByte / baud : 0),
      window_bytes_(static_cast<std::size_t>(std::max(rx_bytes, 2)) - 1) {}

double SerialLine::arrival(std::size_t bytes) {
  double start_t = free_t_;
  // The confirmation that makes room is the one that matters; at least one line may always go.
  while (!pending_.empty() && in_flight_ + bytes > window_bytes_) {
    start_t = std::max(start_t, pending_.front().confirmed_t);
    in_flight_ -= pending_.front().bytes;
    pending_.pop_front();
  }
  pending_.push_back({bytes, 0});
  in_flight_ += bytes;
  free_t_ = start_t + static_cast<double>(bytes) * byte_t_;
  return free_t_;
}

void SerialLine::confirmed(double time_t) {
  if (!pending_.empty()) pending_.back().confirmed_t = time_t;
}

std::size_t framed_bytes(std::string_view command, std::size_t number, LineFormat format) {
  const std::size_t frame = digits(number) + kFrameBytes;
  const bool dense = format != LineFormat::plain && command.starts_with('G');
  const auto blanks = static_cast<std::size_t>(std::count(command.begin(), command.end(), ' '));
  const std::size_t text = dense ? command.size() - blanks : command.size() + 1;  // and one behind the number
  if (format != LineFormat::packed) return text + frame;
  const auto common = static_cast<std::size_t>(std::count_if(
      command.begin(), command.end(), [](char ch) { return kCommon.find(ch) != std::string_view::npos; }));
  const std::size_t rare = text - common + kRareInFrame;
  return ((text + frame - rare) * kCommonBits + rare * kRareBits + 7) / 8;
}

WiredPlanner::WiredPlanner(const MachineLimits& limits, BlockListener* listener)
    : wired_(limits, listener), line_(line_rate(limits), limits.rx_bytes) {}

void WiredPlanner::receive(std::string_view command) {
  if (wired_.limits().baud <= 0) return;
  const bool s3g = wired_.limits().firmware == Firmware::s3g;
  const double arrival_t =
      line_.arrival(s3g ? kS3gMove : framed_bytes(command, ++number_, wired_.limits().line_format));
  if (arrival_t <= wired_.now()) return;
  if (!ideal_) {
    ideal_ = wired_;
    ideal_->set_listener(nullptr);
  }
  wired_.wait_until(arrival_t);
}

void WiredPlanner::confirm() {
  if (wired_.limits().baud <= 0) return;
  line_.confirmed(wired_.now());
  if (ideal_ && ++since_join_ % kJoinEvery == 0) try_to_join();
}

void WiredPlanner::try_to_join() {
  if (!wired_.plans_like(*ideal_)) return;
  lost_t_ += wired_.now() - ideal_->now();
  ideal_.reset();
}

double WiredPlanner::serial_limited() const {
  const double lost_t = lost_t_ + (ideal_ ? wired_.now() - ideal_->now() : 0);
  return std::max(0.0, lost_t);
}

void WiredPlanner::set_limits(const MachineLimits& limits) {
  wired_.set_limits(limits);
  if (ideal_) ideal_->set_limits(limits);
}
void WiredPlanner::set_flow(float ratio) {
  wired_.set_flow(ratio);
  if (ideal_) ideal_->set_flow(ratio);
}
void WiredPlanner::line_to(const Move& move) {
  wired_.line_to(move);
  if (ideal_) ideal_->line_to(move);
}
void WiredPlanner::arc_to(const Arc& arc) {
  cut_arc(arc, wired_.limits(), [this](const Move& move, const Chord& chord) {
    wired_.chord_to(move, chord);
    if (ideal_) ideal_->chord_to(move, chord);
  });
}
void WiredPlanner::set_position(Axis axis, float position_d) {
  wired_.set_position(axis, position_d);
  if (ideal_) ideal_->set_position(axis, position_d);
}
void WiredPlanner::reset_position(const AxisFloats& position_d) {
  wired_.reset_position(position_d);
  if (ideal_) ideal_->reset_position(position_d);
}
void WiredPlanner::finish() {
  wired_.finish();
  if (ideal_) ideal_->finish();
}
void WiredPlanner::dwell(double seconds) {
  wired_.dwell(seconds);
  if (ideal_) ideal_->dwell(seconds);
}

}  // namespace voidpath::motion

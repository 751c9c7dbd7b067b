#include "firmware-io/marlin/link.h"

#include <algorithm>
#include <cmath>

/// When the wire will have carried what was written, and how long a thread may rest meanwhile.
namespace voidpath::fw::marlin {
namespace {

// Before the wire runs dry the thread wants to be awake and to have written, this much earlier than all but
// one in ten of its awakenings are late. At the most so much of what the window holds: what must be sent
// earlier than that may as well be sent at each ok.
constexpr double kLeastLead_s = 0.0003;
constexpr double kMostLead = 0.3;
// How the estimate of an ok's time moves: up when it was not there on awaking; down by as much, or a quarter
// of what it is off, when it came earlier. A rest ends so much behind it, where there is room.
constexpr double kOkTime_s = 5e-5;
constexpr double kDownAtOnce = 0.25;
// And down when it was there: it may have been for long. One in so many rests then ends too early.
constexpr double kOkTimeDown_s = kOkTime_s / 16;
constexpr double kBehindOk_s = 1e-4;
// From awaking to reading.
constexpr double kAtOnce_s = 1e-4;
// "\nN0 M110 N0*125\n", whose answer tells the round trip.
constexpr int kGreetingBytes = 16;
// How the estimate of that lateness moves: up with the one, down with each of the ten.
constexpr double kLatenessUp_s = 3e-5;
constexpr double kLatenessDown_s = kLatenessUp_s / 10;
constexpr double kMostLateness_s = 0.01;

// The wire is the brake where so many bytes took as long as it takes for them, within this part of it.
constexpr std::uint64_t kPacedBytes = 512;
constexpr double kOffPace = 0.08;
// So much of what the estimates are off goes into them at once. Oks come late by chance, never early: what
// tells of an earlier end counts for more.
constexpr double kFollow = 0.125;
constexpr double kFollowEarlier = 0.25;
constexpr double kFollowLater = 1.0 / 32;

// A longer answer tells of a busy printer, not of the wire.
constexpr double kLongestRoundTrip_s = 0.2;

}  // namespace

void Link::forget_round_trip() noexcept { round_trip_s_ = ok_after_s_ = least_ok_s_ = kLongestRoundTrip_s; }

void Link::learn_round_trip(double seconds) noexcept {
  if (seconds >= round_trip_s_) return;
  round_trip_s_ = seconds;
  ok_after_s_ = least_ok_s_ = std::max(round_trip_s_ - kGreetingBytes * byte_s_, kAtOnce_s);
}

// No wire has exactly the pace that is named, and what is added up by that one ends up far from it. But where
// the wire is the brake, all that has no ok is still to be carried, but for what went while the last ok came.
void Link::follow_wire() noexcept {
  const int out = window_.bytes_in_flight() - window_.withheld();
  const std::uint64_t done = bytes_sent_ - static_cast<std::uint64_t>(std::clamp<std::int64_t>(
                                               out, 0, static_cast<std::int64_t>(bytes_sent_)));
  if (done >= paced_bytes_ + kPacedBytes || done < paced_bytes_) {
    const double pace = done < paced_bytes_
                            ? 0
                            : (received_t_ - paced_t_) / (static_cast<double>(done - paced_bytes_) * byte_s_);
    wire_is_brake_ = std::abs(pace - 1) <= kOffPace;
    // What runs dry now and then is not slow.
    if (wire_is_brake_) pace_ = std::min(pace_ + (pace - pace_) * kFollow, 1.0);
    paced_bytes_ = done;
    paced_t_ = received_t_;
  }
  if (!wire_is_brake_) return;
  const double free_t = received_t_ + std::max(out * byte_s_ * pace_ - least_ok_s_ - kBehindOk_s, 0.0);
  const double off = free_t - wire_free_t_;
  const double shift = off * (off < 0 ? kFollowEarlier : kFollowLater);
  wire_free_t_ += shift;
  for (Outstanding& line : outstanding_) line.gone_t += shift;
}

double Link::rest_until() noexcept {
  if (rested_for_ != 0) note_missed_ok();
  awaited_ = 0;
  if (!wire_is_faster_) follow_wire();
  if (wire_is_faster_ || !window_.waiting() || window_.draining() || window_.throttled()) return 0;
  const double most = kMostLead * window_.limit_bytes() * byte_s_;
  const double latest = wire_free_t_ - std::min(kLeastLead_s + lateness_s_, most);
  double until = 0;
  for (const Outstanding& line : outstanding_) {
    const double due = line.gone_t + ok_after_s_;
    if (due > latest) break;
    until = due + std::clamp((latest - due) / 2, 0.0, kBehindOk_s);
    awaited_ = line.number;
  }
  return until;
}

void Link::note_rested(double until, double t) noexcept {
  const bool later = t - until > lateness_s_;
  lateness_s_ = std::clamp(lateness_s_ + (later ? kLatenessUp_s : -kLatenessDown_s), 0.0, kMostLateness_s);
  rested_for_ = awaited_;
  awoke_t_ = t;
}

// The ok that was rested for was not there on awaking.
void Link::note_missed_ok() noexcept {
  rested_for_ = 0;
  ok_after_s_ = std::min(ok_after_s_ + kOkTime_s, kLongestRoundTrip_s);
}

// Its ok has come, at the latest when it was read.
void Link::note_ok_time(const Outstanding& line) noexcept {
  if (line.number == rested_for_) {
    if (received_t_ > awoke_t_ + kAtOnce_s)
      note_missed_ok();
    else
      ok_after_s_ = std::max(ok_after_s_ - kOkTimeDown_s, 0.0);
    rested_for_ = 0;
  }
  const double above_s = std::max(ok_after_s_ - (received_t_ - line.gone_t), 0.0);
  ok_after_s_ = std::max(ok_after_s_ - std::min(above_s, std::max(above_s * kDownAtOnce, kOkTime_s)), 0.0);
}

}  // namespace voidpath::fw::marlin

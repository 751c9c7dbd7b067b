#include "daemon/timing/print_timer.h"

#include <algorithm>
#include <limits>

namespace voidpath::daemon {

void PrintTimer::close_pause(double now_s) {
  if (!paused_) return;
  const double span = now_s - *paused_;
  paused_total_s_ += span;
  // A wait for a temperature within a pause is counted once.
  if (motion_) idle_in_motion_s_ += now_s - std::max(*paused_, *motion_);
  paused_.reset();
}

void PrintTimer::close_heating(double now_s) {
  if (!heating_) return;
  heating_s_ += now_s - *heating_;
  if (motion_ && !paused_) idle_in_motion_s_ += now_s - std::max(*heating_, *motion_);
  heating_.reset();
}

void PrintTimer::enter_layer(std::uint32_t line, double now_s) {
  line_ = line;
  while (current_layer_ < layers_.size() && line >= layers_[current_layer_].first_line) {
    entered_s_.push_back(motion_ ? now_s - *motion_ - idle_s(now_s) : 0.0);
    ++current_layer_;
  }
}

void PrintTimer::on(const fw::Event& event) {
  const double now = event.at_s;
  last_s_ = now;
  if (std::holds_alternative<fw::PrintStarted>(event.what)) {
    started_ = now;
  } else if (const auto* heat = std::get_if<fw::Heating>(&event.what)) {
    if (heat->on && !heating_) heating_ = now;
    if (!heat->on) close_heating(now);
  } else if (std::holds_alternative<fw::MotionStarted>(event.what)) {
    // Start G-code may heat, move and heat again: what counts is the last start before the first layer.
    if (!motion_ || current_layer_ == 0) {
      motion_ = now;
      idle_in_motion_s_ = 0;
    }
  } else if (std::holds_alternative<fw::Paused>(event.what)) {
    if (!paused_) paused_ = now;
  } else if (std::holds_alternative<fw::Resumed>(event.what)) {
    close_pause(now);
  } else if (const auto* done = std::get_if<fw::LineDone>(&event.what)) {
    enter_layer(done->index, now);
  } else if (const auto* stats = std::get_if<fw::LinkStats>(&event.what)) {
    resends_ = stats->resends;
    doubts_ = stats->doubts;
  } else if (std::holds_alternative<fw::PrintFinished>(event.what) ||
             std::holds_alternative<fw::PrintCancelled>(event.what) ||
             std::holds_alternative<fw::PrintFailed>(event.what) ||
             std::holds_alternative<fw::Disconnected>(event.what)) {
    if (ended_) return;
    close_heating(now);
    close_pause(now);
    ended_ = now;
    finished_ = std::holds_alternative<fw::PrintFinished>(event.what);
  }
}

double PrintTimer::idle_s(double now_s) const noexcept {
  double idle = idle_in_motion_s_;
  if (!motion_) return idle;
  if (paused_) {
    idle += now_s - std::max(*paused_, *motion_);
  } else if (heating_) {
    idle += now_s - std::max(*heating_, *motion_);
  }
  return idle;
}

std::optional<double> PrintTimer::measured_s() const {
  if (!finished_ || !motion_) return std::nullopt;
  return *ended_ - *motion_ - idle_in_motion_s_;
}

std::optional<double> PrintTimer::total_s() const {
  if (!started_ || !ended_) return std::nullopt;
  return *ended_ - *started_;
}

double PrintTimer::elapsed_s() const noexcept {
  if (!motion_) return 0;
  const double now = ended_.value_or(last_s_);
  return std::max(0.0, now - *motion_ - idle_s(now));
}

std::vector<double> PrintTimer::layer_s() const {
  std::vector<double> out(layers_.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < entered_s_.size(); ++i) {
    if (i + 1 < entered_s_.size()) {
      out[i] = entered_s_[i + 1] - entered_s_[i];
    } else if (i + 1 == layers_.size() && measured_s()) {
      out[i] = *measured_s() - entered_s_[i];
    }
  }
  return out;
}

double PrintTimer::planned_s() const noexcept {
  double sum = 0;
  for (const auto& layer : layers_) sum += layer.seconds;
  return sum;
}

double PrintTimer::planned_done_s() const noexcept {
  if (ended_ && finished_) return planned_s();
  double sum = 0;
  for (std::size_t i = 0; i + 1 < current_layer_; ++i) sum += layers_[i].seconds;
  if (current_layer_ == 0) return sum;
  // Within a layer, by lines. The last layer's end is not known: it counts as just begun.
  const auto& here = layers_[current_layer_ - 1];
  if (current_layer_ < layers_.size()) {
    const double lines = layers_[current_layer_].first_line - static_cast<double>(here.first_line);
    if (lines > 0)
      sum += here.seconds * std::min(1.0, (line_ - static_cast<double>(here.first_line)) / lines);
  }
  return sum;
}

}  // namespace voidpath::daemon

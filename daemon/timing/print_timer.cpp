#include "daemon/timing/print_timer.h"

#include <algorithm>
#include <limits>

namespace voidpath::daemon {

void PrintTimer::open(std::optional<double>& span, double now_s) {
  if (!span) span = now_s;
  if (!idle_) idle_ = now_s;
}

void PrintTimer::close(std::optional<double>& span, double& total_s, double now_s) {
  if (!span) return;
  total_s += now_s - *span;
  span.reset();
  if (paused_ || heating_) return;
  idle_in_motion_s_ = idle_s(now_s);
  idle_.reset();
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
    if (heat->on)
      open(heating_, now);
    else
      close(heating_, heating_s_, now);
  } else if (std::holds_alternative<fw::MotionStarted>(event.what)) {
    // Start G-code may heat, move and heat again: what counts is the last start before the first layer.
    if (!motion_ || current_layer_ == 0) {
      motion_ = now;
      idle_in_motion_s_ = 0;
    }
  } else if (std::holds_alternative<fw::Paused>(event.what)) {
    open(paused_, now);
  } else if (std::holds_alternative<fw::Resumed>(event.what)) {
    close(paused_, paused_total_s_, now);
  } else if (const auto* done = std::get_if<fw::LineDone>(&event.what)) {
    enter_layer(done->index, now);
  } else if (const auto* stats = std::get_if<fw::LinkStats>(&event.what)) {
    resends_ = stats->resends;
    doubts_ = stats->doubts;
  } else if (fw::ends_print(event.what) || std::holds_alternative<fw::Disconnected>(event.what)) {
    if (ended_) return;
    close(heating_, heating_s_, now);
    close(paused_, paused_total_s_, now);
    ended_ = now;
    finished_ = std::holds_alternative<fw::PrintFinished>(event.what);
  }
}

double PrintTimer::idle_s(double now_s) const noexcept {
  if (!motion_ || !idle_) return idle_in_motion_s_;
  return idle_in_motion_s_ + now_s - std::max(*idle_, *motion_);
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

#pragma once

#include "engine/gcode/estimate.h"
#include "firmware-io/event.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace voidpath::daemon {

/// Measures one print from the session's events, on the session's clock. Pure.
class PrintTimer {
 public:
  explicit PrintTimer(std::vector<gcode::LayerTime> layers) : layers_(std::move(layers)) {}

  void on(const fw::Event& event);

  /// Motion: from the first move after heating to the end, without pauses and later waits for temperature.
  /// Empty before the end of a print.
  std::optional<double> measured_s() const;
  double heating_s() const noexcept { return heating_s_; }
  double paused_s() const noexcept { return paused_total_s_; }
  std::optional<double> total_s() const;
  std::uint64_t resends() const noexcept { return resends_; }
  std::uint64_t doubts() const noexcept { return doubts_; }
  /// s per layer, NaN where its bounds were not seen. Acknowledgements run ahead of the motion by what the
  /// printer buffers, at the start of a layer as at its end.
  std::vector<double> layer_s() const;

  /// Motion time so far at the last event.
  double elapsed_s() const noexcept;
  /// The planner's time of what has been acknowledged, s; of the layers' total planned_s().
  double planned_done_s() const noexcept;
  double planned_s() const noexcept;
  std::size_t layer() const noexcept { return current_layer_; }  ///< 1-based; 0 before the first

 private:
  double idle_s(double now_s) const noexcept;  ///< pauses and waits since motion began
  void enter_layer(std::uint32_t line, double now_s);
  void open(std::optional<double>& span, double now_s);
  void close(std::optional<double>& span, double& total_s, double now_s);

  std::vector<gcode::LayerTime> layers_;
  std::vector<double> entered_s_;  ///< motion time at which each layer was entered
  std::optional<double> started_, motion_, ended_, paused_, heating_;
  std::optional<double> idle_;  ///< since then without a gap: paused, waiting, or both
  double last_s_ = 0;
  double heating_s_ = 0;
  double paused_total_s_ = 0;
  double idle_in_motion_s_ = 0;
  bool finished_ = false;
  std::uint32_t line_ = 0;
  std::size_t current_layer_ = 0;
  std::uint64_t resends_ = 0;
  std::uint64_t doubts_ = 0;
};

}  // namespace voidpath::daemon

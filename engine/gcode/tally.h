#pragma once

#include "engine/gcode/comments.h"
#include "engine/gcode/estimate.h"
#include "engine/gcode/interpreter.h"
#include "engine/motion/block.h"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace voidpath::gcode {

/// Adds up what an Estimate tells, by layer and feature. A block's time becomes final some lines after the
/// line that asked for it, so each carries the layer and feature of its line in its tag.
class Tally : public motion::BlockListener {
 public:
  explicit Tally(OnMotion on_motion) : on_motion_(std::move(on_motion)) {}

  /// Of a command in that line.
  std::uint64_t tag(std::size_t line) const {
    return std::uint64_t{line} << kLineShift | std::uint64_t{layer_} << kLayerShift | feature_;
  }

  void on_block(const motion::TimedBlock& timed) override;
  void on_remark(const Remark& remark, std::size_t line);
  void on_effect(const Effect& effect, float z, std::size_t line);
  /// Time that no block accounts for: dwelling, homing between moves.
  void on_pause(double seconds) { add_to_layer(layer_, seconds); }

  bool extruded_in_xy() const { return extruded_in_xy_; }
  void write(Estimate& out) const;

 private:
  void open_layer(double z_mm, std::size_t line);
  void count_filament(float e_d, bool moves_axes);
  void add_to_layer(std::uint32_t layer, double seconds);
  std::uint32_t feature_id(std::string_view name);

  static constexpr unsigned kLayerShift = 8;  ///< features below
  static constexpr unsigned kLineShift = 28;  ///< 20 bits of layer below

  OnMotion on_motion_;
  Estimate sums_;
  std::vector<LayerTime> layers_;
  std::uint32_t layer_ = 0;        ///< of lines to come; layer n is layers_[n - first_layer_ - 1]
  std::uint32_t first_layer_ = 0;  ///< layers up to this one were guesses and are dropped
  bool told_layers_ = false;       ///< the file's comments name layers
  bool told_layer_changes_ = false;
  std::uint32_t feature_ = 0;
  std::vector<std::pair<std::string, double>> features_ = {{"Other", 0.0}};
  bool extruded_in_xy_ = false;
  bool retracting_ = false;
  double retracted_d_ = 0;  ///< filament drawn back and not yet returned, mm
};

}  // namespace voidpath::gcode

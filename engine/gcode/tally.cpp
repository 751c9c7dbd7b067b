#include "engine/gcode/tally.h"

#include <algorithm>
#include <cmath>

namespace voidpath::gcode {
namespace {

/// More names than any slicer has; bounds memory on odd input.
constexpr std::size_t kMostFeatures = 256;
constexpr std::size_t kMostFeatureName = 80;
constexpr std::uint32_t kMostLayers = 1'000'000;
/// Heights closer than this are one layer. mm
constexpr double kSameHeight_mm = 1e-3;

}  // namespace

void Tally::on_block(const motion::TimedBlock& timed) {
  const motion::Block& block = *timed.block;
  ++sums_.blocks;
  const std::uint64_t layer = block.tag >> kLayerShift & ((1U << (kLineShift - kLayerShift)) - 1);
  const std::size_t feature = block.tag & ((1U << kLayerShift) - 1);
  add_to_layer(static_cast<std::uint32_t>(layer), timed.duration_t);
  if (on_motion_) on_motion_(block.tag >> kLineShift, timed.start_t, timed.start_t + timed.duration_t);
  switch (block.kind) {
    case motion::MoveKind::extrude:
      sums_.extruding_s += timed.duration_t;
      sums_.extruding_mm += static_cast<double>(block.length_d);
      features_[feature].second += timed.duration_t;
      break;
    case motion::MoveKind::travel:
      sums_.travel_s += timed.duration_t;
      sums_.travel_mm += static_cast<double>(block.length_d);
      break;
    case motion::MoveKind::filament:
      sums_.retract_s += timed.duration_t;
      break;
  }
}

void Tally::add_to_layer(std::uint32_t layer, double seconds) {
  if (layer <= first_layer_) return;
  const std::size_t index = layer - first_layer_ - 1;
  if (index < layers_.size()) layers_[index].seconds += seconds;
}

void Tally::open_layer(double z_mm, std::size_t line) {
  if (layer_ >= kMostLayers) return;
  ++layer_;
  layers_.push_back({z_mm, static_cast<std::uint32_t>(line), 0});
}

void Tally::on_remark(const Remark& remark, std::size_t line) {
  switch (remark.kind) {
    case Remark::Kind::none:
      return;
    case Remark::Kind::feature:
      feature_ = feature_id(remark.feature);
      return;
    case Remark::Kind::layer:
    case Remark::Kind::height:
      break;
  }
  if (!told_layers_) {  // from here on the file tells; what was guessed so far is dropped
    told_layers_ = true;
    first_layer_ = layer_;
    layers_.clear();
  }
  if (remark.kind == Remark::Kind::layer) {
    told_layer_changes_ = true;
    open_layer(remark.z_mm.value_or(NAN), line);
  } else if (!told_layer_changes_ || layers_.empty()) {
    if (layers_.empty() || layers_.back().z_mm != *remark.z_mm) open_layer(*remark.z_mm, line);
  } else {
    layers_.back().z_mm = *remark.z_mm;
  }
}

void Tally::on_effect(const Effect& effect, float z, std::size_t line) {
  if (effect.kind != Effect::Kind::move) return;
  ++sums_.moves;
  count_filament(effect.e_d, effect.moves_axes);
  if (!effect.moves_xy || effect.e_d <= 0) return;
  extruded_in_xy_ = true;
  const auto height = static_cast<double>(z);
  if (!told_layers_ && effect.flat && (layers_.empty() || height > layers_.back().z_mm + kSameHeight_mm)) {
    open_layer(height, line);
  }
  // A layer opened by a comment without height takes it from its first extrusion.
  if (!layers_.empty() && std::isnan(layers_.back().z_mm)) layers_.back().z_mm = height;
}

void Tally::count_filament(float e_d, bool moves_axes) {
  if (e_d < 0) {
    if (!retracting_) ++sums_.retractions;
    retracting_ = true;
    retracted_d_ -= static_cast<double>(e_d);
  } else if (e_d > 0) {
    retracting_ = false;
    const double returned = std::min(retracted_d_, static_cast<double>(e_d));
    // Extruding on the way means that whatever was drawn back is meant to stay so.
    retracted_d_ = moves_axes ? 0 : retracted_d_ - returned;
    sums_.filament_mm += static_cast<double>(e_d) - (moves_axes ? 0 : returned);
  }
}

std::uint32_t Tally::feature_id(std::string_view name) {
  name = name.substr(0, kMostFeatureName);
  for (std::size_t i = 0; i < features_.size(); ++i) {
    if (features_[i].first == name) return static_cast<std::uint32_t>(i);
  }
  if (name.empty() || features_.size() >= kMostFeatures) return 0;
  features_.emplace_back(name, 0.0);
  return static_cast<std::uint32_t>(features_.size() - 1);
}

void Tally::write(Estimate& out) const {
  const Estimate& s = sums_;
  out.extruding_s = s.extruding_s;
  out.travel_s = s.travel_s;
  out.retract_s = s.retract_s;
  out.moves = s.moves;
  out.blocks = s.blocks;
  out.extruding_mm = s.extruding_mm;
  out.travel_mm = s.travel_mm;
  out.filament_mm = s.filament_mm;
  out.retractions = s.retractions;
  out.layers = layers_;
  for (LayerTime& layer : out.layers) {
    if (std::isnan(layer.z_mm)) layer.z_mm = 0;
  }
  if (features_.size() == 1) return;  // no comment told
  for (const auto& [name, seconds] : features_) {
    if (seconds > 0) out.by_feature[name] += seconds;
  }
}

}  // namespace voidpath::gcode

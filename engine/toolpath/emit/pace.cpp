#include "engine/toolpath/emit/pace.h"

#include "engine/toolpath/emit/layer_timer.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace voidpath::toolpath {

namespace {

/// Halvings in the search for the slow-down: to a millionth of the speed.
constexpr int kBisections = 24;
/// Speeds in settings are never taken lower than this, mm/s: a print has to end.
constexpr double kLeastSpeedMmS = 0.1;
/// A layer is long enough when it lacks less than this, s.
constexpr double kSameSeconds = 0.02;
/// How often a slow-down is mended for what corners cost: each round leaves about a fifth of the error.
constexpr int kRounds = 8;

double role_speed(Role role, const SpeedSettings& s) {
  switch (role) {
    case Role::external_perimeter:
      return s.external_perimeter;
    case Role::perimeter:
    case Role::skirt_brim:
      return s.perimeter;
    case Role::overhang_perimeter:
    case Role::bridge_infill:
      return s.bridge;
    case Role::internal_bridge:
      return s.internal_bridge;
    case Role::infill:
      return s.infill;
    case Role::solid_infill:
      return s.solid_infill;
    case Role::top_solid_infill:
      return s.top_solid_infill;
    case Role::gap_fill:
      return s.gap_fill;
    case Role::support:
    case Role::support_interface:
      return s.support;
  }
  return s.perimeter;
}

double role_acceleration(Role role, const AccelerationSettings& a) {
  switch (role) {
    case Role::external_perimeter:
      return a.external_perimeter;
    case Role::perimeter:
    case Role::skirt_brim:
    case Role::gap_fill:
      return a.perimeter;
    case Role::overhang_perimeter:
    case Role::bridge_infill:
    case Role::internal_bridge:
      return a.bridge;
    case Role::infill:
      return a.infill;
    case Role::solid_infill:
      return a.solid_infill;
    case Role::top_solid_infill:
      return a.top_solid_infill;
    case Role::support:
    case Role::support_interface:
      return a.support;
  }
  return a.print;
}

/// The fan's share of its full speed that this layer allows: nothing at first, then evenly more.
double fan_ramp(std::size_t layer, const CoolingSettings& c) {
  const auto off = static_cast<std::size_t>(std::max(c.fan_off_layers, 0));
  const auto full = static_cast<std::size_t>(std::max(c.full_fan_at_layer, 0));
  if (layer < off) return 0;
  if (layer + 1 >= full) return 1;
  return static_cast<double>(layer + 1 - off) / static_cast<double>(full - off);
}

double length_mm(const Path& path) {
  double sum = geom::length(path.points);
  if (path.closed && path.points.size() > 1) sum += geom::distance(path.points.back(), path.points.front());
  return sum / geom::kNmPerMm;
}

/// A layer's lengths at their speeds: no corner costs anything.
class Lengths {
 public:
  Lengths(const LayerPlan& layer, std::size_t index, const PrintSettings& settings) {
    const double travel = std::max(settings.speed.travel, kLeastSpeedMmS);
    const geom::Point* at = nullptr;
    for (const Path& p : layer.paths) {
      if (p.points.empty()) continue;
      if (at != nullptr) travel_s_ += geom::distance(*at, p.points.front()) / geom::kNmPerMm / travel;
      at = p.closed ? &p.points.front() : &p.points.back();
      stretches_.push_back({length_mm(p), path_speed_mm_s(p, index, settings), p.role});
    }
  }

  double seconds(const Pace& pace) const {
    double sum = travel_s_;
    for (const Stretch& s : stretches_) sum += s.length / pace.apply(s.speed, s.role);
    return sum;
  }

  /// The quickest pace that takes so long; the slowest allowed where none does.
  double factor_for(double seconds_wanted, Pace pace) const {
    double low = 0, high = 1;
    for (int i = 0; i < kBisections; ++i) {
      pace.factor = 0.5 * (low + high);
      (seconds(pace) >= seconds_wanted ? low : high) = pace.factor;
    }
    return low;
  }

 private:
  struct Stretch {
    double length, speed;
    Role role;
  };
  std::vector<Stretch> stretches_;
  double travel_s_ = 0;
};

/// Corners cost less the slower it goes: what they cost at one pace tells the next one, until they agree.
void slow_down(Pace& pace, const Lengths& lengths, const LayerTimer& timer, double wanted_s) {
  pace.seconds = timer.seconds(pace);
  for (int round = 0; round < kRounds && pace.seconds < wanted_s - kSameSeconds; ++round) {
    const double corners = pace.seconds - lengths.seconds(pace);
    const double factor = lengths.factor_for(wanted_s - corners, pace);
    if (factor >= pace.factor) break;
    pace.factor = factor;
    pace.seconds = timer.seconds(pace);
  }
}

}  // namespace

double path_speed_mm_s(const Path& path, std::size_t layer, const PrintSettings& settings) {
  double v = layer == 0 ? settings.speed.first_layer : role_speed(path.role, settings.speed);
  if (path.max_speed_mm_s > 0) v = std::min(v, path.max_speed_mm_s);
  const double flow = path.area_mm2 * settings.filament.flow;
  if (settings.filament.max_flow_mm3_s > 0 && flow > 0)
    v = std::min(v, settings.filament.max_flow_mm3_s / flow);
  return std::max(v, kLeastSpeedMmS);
}

double path_acceleration_mm_s2(const Path& path, std::size_t layer, const PrintSettings& settings) {
  const AccelerationSettings& a = settings.acceleration;
  if (a.print <= 0) return 0;
  if (layer == 0 && a.first_layer > 0) return a.first_layer;
  const double own = role_acceleration(path.role, a);
  return own > 0 ? own : a.print;
}

bool keeps_speed(Role role) {
  return role == Role::bridge_infill || role == Role::internal_bridge || role == Role::overhang_perimeter;
}

double Pace::apply(double speed_mm_s, Role role) const {
  if (factor >= 1 || keeps_speed(role)) return speed_mm_s;
  return std::max(speed_mm_s * factor, std::min(speed_mm_s, floor_mm_s));
}

Pace pace_of_layer(const LayerPlan& layer, std::size_t index, const PrintSettings& settings,
                   const motion::MachineLimits& limits, const std::vector<Travel>& travels) {
  const CoolingSettings& c = settings.cooling;
  const Lengths lengths(layer, index, settings);
  Pace out;
  out.floor_mm_s = std::max(c.min_speed_mm_s, kLeastSpeedMmS);
  out.seconds = lengths.seconds(out);
  if (!c.enabled) return out;
  if (out.seconds < std::max(c.slow_below_s, c.full_fan_below_s))
    slow_down(out, lengths, LayerTimer(layer, index, settings, limits, travels), c.slow_below_s);
  const double ramp = fan_ramp(index, c);
  const double range = std::max(c.full_fan_below_s - c.slow_below_s, 1e-9);
  const double quick = out.factor < 1 ? 1 : std::clamp((c.full_fan_below_s - out.seconds) / range, 0.0, 1.0);
  out.fan = ramp * std::clamp(c.fan_min + quick * (c.fan_max - c.fan_min), 0.0, 1.0);
  out.bridge_fan = ramp * std::max(std::clamp(c.bridge_fan, 0.0, 1.0), out.fan);
  return out;
}

}  // namespace voidpath::toolpath

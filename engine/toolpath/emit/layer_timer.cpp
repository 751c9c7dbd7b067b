#include "engine/toolpath/emit/layer_timer.h"

#include "engine/motion/planner.h"

#include <cmath>
#include <numbers>

namespace voidpath::toolpath {

namespace {

/// The moves of one layer, given to a planner that stands at its first point.
class Run {
 public:
  Run(const PrintSettings& settings, const motion::MachineLimits& limits)
      : settings_(settings), limits_(limits), planner_(limits) {
    const double radius = 0.5 * settings.filament.diameter_mm;
    filament_per_mm3_ = settings.filament.flow / (std::numbers::pi * radius * radius);
  }

  void begin(const geom::Point& at) {
    put(at);
    planner_.reset_position(at_);
    begun_ = true;
  }
  bool begun() const { return begun_; }

  /// As M204 S does; 0 leaves the printer's own.
  void accelerate(double mm_s2) {
    if (mm_s2 <= 0 || mm_s2 == limits_.print_acceleration_mm_s2) return;
    limits_.print_acceleration_mm_s2 = limits_.travel_acceleration_mm_s2 = mm_s2;
    planner_.set_limits(limits_);
  }

  void travel(const geom::Point& to) {
    put(to);
    go(settings_.speed.travel);
  }
  void filament(double mm, double speed) {
    at_[motion::kE] += static_cast<float>(mm);
    go(speed);
  }
  void extrude(const geom::Point& from, const geom::Point& to, double area_mm2, double speed) {
    put(to);
    at_[motion::kE] +=
        static_cast<float>(geom::distance(from, to) / geom::kNmPerMm * area_mm2 * filament_per_mm3_);
    go(speed);
  }

  double seconds() {
    planner_.finish();
    return planner_.now();
  }

 private:
  void put(const geom::Point& p) {
    at_[0] = static_cast<float>(geom::to_mm(p.x));
    at_[1] = static_cast<float>(geom::to_mm(p.y));
  }
  void go(double speed) { planner_.line_to({at_, static_cast<float>(speed), 0}); }

  const PrintSettings& settings_;
  motion::MachineLimits limits_;
  motion::Planner planner_;
  motion::AxisFloats at_{};
  double filament_per_mm3_ = 0;
  bool begun_ = false;
};

}  // namespace

double LayerTimer::seconds(const Pace& pace) const {
  const RetractSettings& retract = settings_.retract;
  Run run(settings_, limits_);
  for (std::size_t k = 0; k < layer_.paths.size(); ++k) {
    const Path& path = layer_.paths[k];
    if (path.points.size() < 2) continue;
    if (!run.begun()) {
      run.begin(path.points.front());
    } else {
      const bool away = k < travels_.size() && travels_[k].retract && retract.length_mm > 0;
      if (away) run.filament(-retract.length_mm, retract.speed_mm_s);
      if (settings_.acceleration.print > 0) run.accelerate(settings_.acceleration.travel);
      if (k < travels_.size())
        for (const geom::Point& p : travels_[k].via) run.travel(p);
      run.travel(path.points.front());
      if (away) run.filament(retract.length_mm, retract.deretract_speed_mm_s);
    }
    run.accelerate(path_acceleration_mm_s2(path, index_, settings_));
    const double speed = pace.apply(path_speed_mm_s(path, index_, settings_), path.role);
    for (std::size_t i = 1; i < path.points.size(); ++i)
      run.extrude(path.points[i - 1], path.points[i], path.area_mm2, speed);
    if (path.closed) run.extrude(path.points.back(), path.points.front(), path.area_mm2, speed);
  }
  return run.begun() ? run.seconds() : 0;
}

}  // namespace voidpath::toolpath

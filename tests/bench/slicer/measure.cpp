#include "tests/bench/slicer/measure.h"

#include "engine/gcode/walk.h"
#include "engine/geom/polygon_ops.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

namespace voidpath::bench {

namespace {

/// Travels by the layer they happen in.
class Travels {
 public:
  explicit Travels(const slice::LayerStack& stack) : stack_(stack), lines_(stack.size()) {}

  void read(std::istream& in) {
    gcode::walk(in, [this](const gcode::Step& step) {
      if (step.pushed_mm <= 0 && step.moves_xy()) travel(step);
    });
  }

  double outside_m() const {
    double sum = 0;
    for (std::size_t i = 0; i < stack_.size(); ++i)
      for (const auto& piece : geom::clip_outside(lines_[i], stack_[i].regions)) sum += geom::length(piece);
    return sum / geom::kNmPerMm / 1000;
  }

 private:
  void travel(const gcode::Step& step) {
    const auto above = std::lower_bound(
        stack_.begin(), stack_.end(), step.to[2],
        [](const slice::Layer& l, double z) { return l.span.top_mm + 0.5 * l.span.height_mm() < z; });
    if (above == stack_.end() || stack_.empty()) return;
    auto point = [](const gcode::Position& p) {
      return geom::Point{geom::from_mm(p[0]), geom::from_mm(p[1])};
    };
    lines_[static_cast<std::size_t>(above - stack_.begin())].push_back({point(step.from), point(step.to)});
  }

  const slice::LayerStack& stack_;
  std::vector<geom::Polylines> lines_;
};

}  // namespace

Print measure(const std::filesystem::path& file, const slice::LayerStack& stack,
              const motion::MachineLimits& limits) {
  const gcode::Estimate e = gcode::estimate_file(file, limits);
  Travels travels(stack);
  std::ifstream in(file, std::ios::binary);
  travels.read(in);
  return {e.predicted_s,       e.filament_mm / 1000, e.travel_mm / 1000,
          travels.outside_m(), e.retractions,        e.moves};
}

}  // namespace voidpath::bench

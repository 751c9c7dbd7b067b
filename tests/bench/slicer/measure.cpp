#include "tests/bench/slicer/measure.h"

#include "engine/gcode/reader.h"
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
    gcode::LineReader reader(in);
    std::string_view line;
    while (reader.next(line)) obey(gcode::parse_command(gcode::split_line(line).code));
  }

  double outside_m() const {
    double sum = 0;
    for (std::size_t i = 0; i < stack_.size(); ++i)
      for (const auto& piece : geom::clip_outside(lines_[i], stack_[i].regions)) sum += geom::length(piece);
    return sum / geom::kNmPerMm / 1000;
  }

 private:
  void obey(const gcode::Command& c) {
    if (c.is('M', 82)) relative_e_ = false;
    if (c.is('M', 83)) relative_e_ = true;
    if (c.is('G', 90)) relative_ = false;
    if (c.is('G', 91)) relative_ = true;
    if (c.is('G', 92) && c.has('E')) e_ = static_cast<double>(c.get('E'));
    if (!c.is('G', 0) && !c.is('G', 1)) return;
    const double x = target(c, 'X', x_), y = target(c, 'Y', y_);
    z_ = target(c, 'Z', z_);
    double pushed = 0;
    if (c.has('E')) {
      const double e = static_cast<double>(c.get('E'));
      pushed = relative_e_ ? e : e - e_;
      e_ = e;
    }
    if (pushed <= 0 && (x != x_ || y != y_)) travel(x, y);
    x_ = x, y_ = y;
  }

  double target(const gcode::Command& c, char word, double now) const {
    if (!c.has(word)) return now;
    const double value = static_cast<double>(c.get(word));
    return relative_ ? now + value : value;
  }

  void travel(double x, double y) {
    const auto above = std::lower_bound(
        stack_.begin(), stack_.end(), z_,
        [](const slice::Layer& l, double z) { return l.span.top_mm + 0.5 * l.span.height_mm() < z; });
    if (above == stack_.end() || stack_.empty()) return;
    auto point = [](double px, double py) { return geom::Point{geom::from_mm(px), geom::from_mm(py)}; };
    lines_[static_cast<std::size_t>(above - stack_.begin())].push_back({point(x_, y_), point(x, y)});
  }

  const slice::LayerStack& stack_;
  std::vector<geom::Polylines> lines_;
  bool relative_ = false, relative_e_ = false;
  double x_ = 0, y_ = 0, z_ = 0, e_ = 0;
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

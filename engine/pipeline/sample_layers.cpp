#include "engine/pipeline/sample_layers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>

namespace voidpath::pipeline {

namespace {

using toolpath::LayerGroup;
using toolpath::SliceSettings;

constexpr double kMm2 = geom::kNmPerMm * geom::kNmPerMm;
/// Cost of getting to a region and starting there, s.
constexpr double kRegion_s = 0.5;
/// How much a group of many layers is to be split although nothing changes in it, as a share of its time:
/// supports are found with groups as layers, which must not be too thick.
constexpr double kPlainSplit = 0.02;

struct Facts {
  double area_mm2 = 0;
  double outline_mm = 0;
  double regions = 0;
};

Facts facts_of(const slice::Layer& layer) {
  Facts f;
  f.area_mm2 = geom::area(layer.regions) / kMm2;
  for (const auto& ring : geom::rings_of(layer.regions))
    f.outline_mm += geom::perimeter(ring) / geom::kNmPerMm;
  f.regions = static_cast<double>(layer.regions.size());
  return f;
}

/// Time of a layer at constant speeds, split by what it is spent on.
using Parts = std::array<double, 3>;  // walls, fill, getting about

double sum(const Parts& p) { return p[0] + p[1] + p[2]; }

std::vector<Parts> parts_of(const slice::LayerStack& stack, const toolpath::PrintSettings& settings) {
  const SliceSettings& s = settings.slice;
  const auto& v = settings.speed;
  const std::size_t n = stack.size();
  std::vector<Facts> facts;
  for (const auto& layer : stack) facts.push_back(facts_of(layer));
  const auto area = [&](std::ptrdiff_t i) {
    return i < 0 || i >= static_cast<std::ptrdiff_t>(n) ? 0 : facts[static_cast<std::size_t>(i)].area_mm2;
  };
  std::vector<Parts> out(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto at = static_cast<std::ptrdiff_t>(i);
    // Where the area shrinks upwards or grows there is skin, as many layers deep as the settings say.
    double skin = 0;
    for (int k = 0; k < s.top_layers; ++k) skin += std::max(0.0, area(at + k) - area(at + k + 1));
    for (int k = 0; k < s.bottom_layers; ++k) skin += std::max(0.0, area(at - k) - area(at - k - 1));
    skin = std::min(skin, facts[i].area_mm2);
    const double sparse = (facts[i].area_mm2 - skin) * s.infill_density;
    const double wall_mm = facts[i].outline_mm * std::max(s.perimeters, 0);
    const double width = std::max(s.line_width_mm, 1e-3);
    if (i == 0)
      out[i] = {wall_mm / v.first_layer, (skin + sparse) / width / v.first_layer,
                kRegion_s * facts[i].regions};
    else
      out[i] = {wall_mm / v.perimeter, (skin / v.solid_infill + sparse / v.infill) / width,
                kRegion_s * facts[i].regions};
  }
  return out;
}

/// A run of layers and the best place to cut it.
struct Run {
  std::size_t first, count;
  std::size_t cut = 0;  ///< length of the first part
  double gain = 0;
  bool operator<(const Run& other) const {
    return gain != other.gain ? gain < other.gain : first > other.first;
  }
};

/// How far the layers of a run are from one another, s: sums over the run in constant time.
class Spread {
 public:
  explicit Spread(const std::vector<Parts>& parts) : sums_(parts.size() + 1), squares_(parts.size() + 1) {
    for (std::size_t i = 0; i < parts.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        sums_[i + 1][k] = sums_[i][k] + parts[i][k];
        squares_[i + 1][k] = squares_[i][k] + parts[i][k] * parts[i][k];
      }
  }
  /// What the run's time may be off by when one layer stands for all.
  double operator()(std::size_t first, std::size_t count) const {
    const auto n = static_cast<double>(count);
    double off = 0;
    double total = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double s = sums_[first + count][k] - sums_[first][k];
      const double q = squares_[first + count][k] - squares_[first][k];
      off += std::sqrt(std::max(0.0, q - s * s / n) * n);
      total += s;
    }
    const double share = n / static_cast<double>(sums_.size());
    return off + kPlainSplit * total * share;
  }

 private:
  std::vector<Parts> sums_, squares_;
};

Run with_best_cut(std::size_t first, std::size_t count, const Spread& spread) {
  Run run{first, count};
  const double whole = spread(first, count);
  for (std::size_t cut = 1; cut < count; ++cut) {
    const double gain = whole - spread(first, cut) - spread(first + cut, count - cut);
    if (gain > run.gain) run.gain = gain, run.cut = cut;
  }
  return run;
}

std::size_t sample_of(const Run& run, const std::vector<Parts>& parts, bool odd) {
  double mean = 0;
  for (std::size_t i = 0; i < run.count; ++i) mean += sum(parts[run.first + i]);
  mean /= static_cast<double>(run.count);
  std::size_t best = run.first;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = run.first; i < run.first + run.count; ++i) {
    const double place = (static_cast<double>(i - run.first) + 0.5) / static_cast<double>(run.count) - 0.5;
    const double off = std::abs(sum(parts[i]) - mean) / std::max(mean, 1e-9);
    const double far = std::abs(place) + 2 * off + ((i % 2 == 1) == odd ? 0 : 0.2);
    if (far < least) least = far, best = i;
  }
  return best;
}

}  // namespace

std::vector<double> rough_seconds(const slice::LayerStack& stack, const toolpath::PrintSettings& settings) {
  std::vector<double> out;
  const bool slows = settings.cooling.enabled;
  for (const Parts& p : parts_of(stack, settings))
    out.push_back(std::max(sum(p), slows ? settings.cooling.slow_below_s : 0));
  return out;
}

std::vector<LayerGroup> choose_samples(const slice::LayerStack& stack,
                                       const toolpath::PrintSettings& settings, std::size_t most) {
  const std::vector<Parts> parts = parts_of(stack, settings);
  const Spread spread(parts);
  std::vector<Run> done;
  std::priority_queue<Run> open;
  if (!stack.empty()) done.push_back({0, 1});
  if (stack.size() > 1) open.push(with_best_cut(1, stack.size() - 1, spread));
  while (!open.empty()) {
    const Run run = open.top();
    open.pop();
    if (run.cut == 0 || done.size() + open.size() + 2 > std::max<std::size_t>(most, 3)) {
      done.push_back(run);
      continue;
    }
    open.push(with_best_cut(run.first, run.cut, spread));
    open.push(with_best_cut(run.first + run.cut, run.count - run.cut, spread));
  }
  std::sort(done.begin(), done.end(), [](const Run& a, const Run& b) { return a.first < b.first; });
  std::vector<LayerGroup> out;
  for (const Run& run : done)
    out.push_back({run.first, run.count, sample_of(run, parts, out.size() % 2 == 1)});
  return out;
}

}  // namespace voidpath::pipeline

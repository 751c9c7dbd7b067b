#include "engine/toolpath/threads.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support_task.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Polyline;

/// Threads are no wider than this share of a line: wider ones keep their place over a short way.
constexpr double kThreadShare = 0.75;
/// Lines reach this far over from a support beside them, mm.
constexpr double kBesideSupportMm = 0.5;
/// A line is carried by one below that it overlaps by so much of its width, whatever the angle.
constexpr double kCarriedShare = 0.25;
/// Hold is looked for this often along a thread, mm.
constexpr double kStepMm = 0.1;
/// The tip of a thread may stick out by this.
constexpr int kTipSteps = 3;
constexpr double kTipMm = kTipSteps * kStepMm;
/// What a cut leaves of a thread's own end is thinner than twice this, mm.
constexpr double kSliverMm = 0.04;
/// What a thread leaves bare is wider than it by this, mm: nothing of it is left beside.
constexpr double kBareMarginMm = 0.4;

Point between(const Point& a, const Point& b, double t) {
  return {a.x + std::llround(t * static_cast<double>(b.x - a.x)),
          a.y + std::llround(t * static_cast<double>(b.y - a.y))};
}

/// The line in points no further apart than a step.
Polyline fine(const Polyline& line) {
  Polyline out{line.front()};
  for (std::size_t k = 1; k < line.size(); ++k) {
    const double length = geom::distance(line[k - 1], line[k]) / geom::kNmPerMm;
    const int n = std::max(1, static_cast<int>(std::ceil(length / kStepMm)));
    for (int j = 1; j <= n; ++j)
      out.push_back(j == n ? line[k] : between(line[k - 1], line[k], static_cast<double>(j) / n));
  }
  return out;
}

class Cutter {
 public:
  Cutter(std::vector<Path>& paths, const geom::Regions& ground, double line_width_mm)
      : paths_(paths), ground_(ground), thin_mm_(kThreadShare * line_width_mm) {
    for (const Path& p : paths)
      if (is_line(p)) ++at_[key(p.points.front())], ++at_[key(p.points.back())];
  }

  geom::Regions run() {
    for (bool more = true; more;) {
      more = false;
      for (Path& path : paths_)
        for (int end = 0; end < 2; ++end) {
          if (is_line(path) && path.width_mm <= thin_mm_) more = cut(path) || more;
          std::reverse(path.points.begin(), path.points.end());
        }
    }
    if (!bare_.empty()) std::erase_if(paths_, [](const Path& p) { return p.points.empty(); });
    return std::move(bare_);
  }

 private:
  static bool is_line(const Path& p) { return p.role == Role::gap_fill && !p.closed && p.points.size() > 1; }
  static std::pair<geom::Coord, geom::Coord> key(const Point& p) { return {p.x, p.y}; }

  /// Back from the first point; whether anything was.
  bool cut(Path& path) {
    Polyline& line = path.points;
    if (at_[key(line.front())] != 1 || ground_.contains(line.front())) return false;
    Polyline points = fine(line);
    const auto held =
        std::find_if(points.begin(), points.end(), [&](const Point& p) { return ground_.contains(p); });
    if (held != points.end() && held - points.begin() <= kTipSteps + 1) return false;
    --at_[key(line.front())];
    if (held == points.end()) {
      --at_[key(line.back())];
      leave(line, path.width_mm);
      line.clear();
      return true;
    }
    const auto first = held - kTipSteps;
    leave({points.begin(), first + 1}, path.width_mm);
    line.assign(first, points.end());
    ++at_[key(line.front())];
    return true;
  }

  void leave(const Polyline& thread, double width_mm) {
    bare_ = quick_unite(bare_, bead_area({thread}, (width_mm + kBareMarginMm) * geom::kNmPerMm));
  }

  std::vector<Path>& paths_;
  geom::AreaGrid ground_;
  double thin_mm_;
  geom::Regions bare_;
  std::map<std::pair<geom::Coord, geom::Coord>, int> at_;  ///< how many ends lie there
};

double lean_mm(const slice::Layer& layer, const SliceSettings& s) {
  const double angle = std::clamp(s.support_angle_deg, 0.0, 89.0) * std::numbers::pi / 180;
  return std::max(layer.span.height_mm() * std::tan(angle), kCarriedShare * s.line_width_mm);
}

/// What carries the lines of layer i: the layer below without what is missing there, lower ones over a gap in
/// which no support has room, and support.
geom::Regions ground_of(std::size_t i, const slice::LayerStack& stack, const SupportAreas& support,
                        const geom::Regions& missing, const SliceSettings& s) {
  geom::Regions out = stack[i - 1].regions;
  if (!missing.empty()) out = geom::open(quick_subtract(out, missing), from_mm(kSliverMm));
  const slice::LayerSpan& span = stack[i].span;
  const double no_room = 2 * s.support_z_gap_mm + span.height_mm() - kStepMm;
  for (std::size_t j = i - 1; j-- > 0 && span.bottom_mm - stack[j].span.top_mm < no_room;)
    out = quick_unite(out, stack[j].regions);
  const double lean = lean_mm(stack[i], s);
  const geom::Regions held = printed_area(support);
  if (!held.empty())
    out = quick_unite(out, geom::offset(held, from_mm(std::max(kBesideSupportMm - lean, 0.0))));
  return geom::offset(out, from_mm(lean));
}

/// Whether threads may hang in layer i at all.
bool may_hang(const LayerPlan& layer, std::size_t i, const slice::LayerStack& stack, const SliceSettings& s) {
  const auto thin = [&](const Path& p) {
    return p.role == Role::gap_fill && p.width_mm <= kThreadShare * s.line_width_mm;
  };
  if (std::none_of(layer.paths.begin(), layer.paths.end(), thin)) return false;
  const double most = lean_mm(stack[i], s) + kTipMm;
  return !quick_subtract(stack[i].regions, geom::offset(stack[i - 1].regions, from_mm(most))).empty();
}

}  // namespace

geom::Regions cut_threads(std::vector<Path>& paths, const geom::Regions& ground, double line_width_mm) {
  return Cutter(paths, ground, line_width_mm).run();
}

void cut_threads(std::span<LayerPlan> layers, const slice::LayerStack& stack,
                 const std::vector<SupportAreas>& supports, const SliceSettings& settings,
                 const run::Context& ctx) {
  std::vector<geom::Regions> bare(layers.size());
  const auto cut = [&](std::size_t i, const geom::Regions& missing) {
    const std::size_t bearer = layer_below_gap(stack, i, settings.support_z_gap_mm);
    if (bearer >= supports.size()) return;  // the plate is as near as a support would be
    append(bare[i], cut_threads(layers[i].paths, ground_of(i, stack, supports[bearer], missing, settings),
                                settings.line_width_mm));
  };
  run::parallel_for(ctx, layers.size(), [&](std::size_t i) {
    if (i > 0 && may_hang(layers[i], i, stack, settings)) cut(i, {});
  });
  for (std::size_t i = 1; i < layers.size(); ++i)
    if (!bare[i - 1].empty()) cut(i, geom::unite(geom::rings_of(bare[i - 1])));
}

}  // namespace voidpath::toolpath

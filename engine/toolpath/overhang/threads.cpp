#include "engine/toolpath/overhang/threads.h"

#include "engine/geom/area_grid.h"
#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/bead_area.h"
#include "engine/toolpath/lean.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/support/support_task.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Polyline;

/// Threads are no wider than this share of a line: wider ones keep their place over a short way.
constexpr double kThreadShare = 0.75;
/// With support any gap line is cut: none is wider than this many lines.
constexpr double kAnyShare = 4.0;
/// Hold is looked for this often along a thread, mm.
constexpr double kStepMm = 0.1;
/// The tip of a thread may stick out by this.
constexpr int kTipSteps = 3;
constexpr double kTipMm = kTipSteps * kStepMm;
/// What carries a line is looked for this far around it, mm.
constexpr double kAroundMm = 2.0;
/// What is thinner than twice this, mm, gets no line, and is no more than what a cut leaves of a thread's
/// end.
constexpr double kSliverMm = 0.045;
/// What a thread leaves bare is wider than it by this, mm: nothing of it is left beside.
constexpr double kBareMarginMm = 0.4;
/// An end is surely held where there is firm ground, in one of so many directions, within this share of the
/// lean.
constexpr double kLeanShare = 0.9;
constexpr int kWays = 8;

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
  /// Beside `where`, if that is given, everything is held.
  Cutter(std::vector<Path>& paths, const geom::Regions& ground, double widest_mm,
         const geom::Regions* where = nullptr)
      : paths_(paths), ground_(ground), widest_mm_(widest_mm) {
    if (where != nullptr) where_.emplace(*where);
    for (const Path& p : paths)
      if (is_line(p)) ++at_[key(p.points.front())], ++at_[key(p.points.back())];
  }

  geom::Regions run() {
    for (bool more = true; more;) {
      more = false;
      for (Path& path : paths_)
        for (int end = 0; end < 2; ++end) {
          if (is_line(path) && path.width_mm <= widest_mm_) more = cut(path) || more;
          std::reverse(path.points.begin(), path.points.end());
        }
    }
    if (!bare_.empty()) std::erase_if(paths_, [](const Path& p) { return p.points.empty(); });
    return std::move(bare_);
  }

 private:
  static bool is_line(const Path& p) { return p.role == Role::gap_fill && !p.closed && p.points.size() > 1; }
  static std::pair<geom::Coord, geom::Coord> key(const Point& p) { return {p.x, p.y}; }

  bool is_held(const Point& p) const { return (where_ && !where_->contains(p)) || ground_.contains(p); }

  /// Back from the first point; whether anything was.
  bool cut(Path& path) {
    Polyline& line = path.points;
    if (at_[key(line.front())] != 1 || is_held(line.front())) return false;
    Polyline points = fine(line);
    const auto held = std::find_if(points.begin(), points.end(), [&](const Point& p) { return is_held(p); });
    if (held != points.end() && held - points.begin() <= kTipSteps + 1) return false;
    if (held == points.end() && at_[key(line.back())] == 1) return shorten(path);
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

  /// Of a line that hangs whole stays a tip in its middle, for the layers above to go on from.
  bool shorten(Path& path) {
    Polyline& line = path.points;
    const double length = geom::length(line) / geom::kNmPerMm;
    if (length <= kTipMm + kStepMm) return false;
    Polyline points = fine(line);
    const auto n = static_cast<std::ptrdiff_t>(points.size());
    const std::ptrdiff_t first = std::max<std::ptrdiff_t>((n - 1 - kTipSteps) / 2, 0);
    const std::ptrdiff_t last = std::min(first + kTipSteps, n - 1);
    // As in cut(), what is left bare reaches a little over both ends of the tip.
    if (first > kTipSteps) leave({points.begin(), points.begin() + first - kTipSteps + 1}, path.width_mm);
    if (last + kTipSteps < n - 1) leave({points.begin() + last + kTipSteps, points.end()}, path.width_mm);
    --at_[key(line.front())];
    --at_[key(line.back())];
    line.assign(points.begin() + first, points.begin() + last + 1);
    ++at_[key(line.front())];
    ++at_[key(line.back())];
    return true;
  }

  void leave(const Polyline& thread, double width_mm) {
    bare_ = quick_unite(bare_, bead_area({thread}, (width_mm + kBareMarginMm) * geom::kNmPerMm));
  }

  std::vector<Path>& paths_;
  geom::AreaGrid ground_;
  std::optional<geom::AreaGrid> where_;
  double widest_mm_;
  geom::Regions bare_;
  std::map<std::pair<geom::Coord, geom::Coord>, int> at_;  ///< how many ends lie there
};

double widest_mm(const SliceSettings& s) {
  return (s.support == SupportMode::none ? kThreadShare : kAnyShare) * s.line_width_mm;
}

/// Of lines that go on from each other: around those of which one has an end in the air, further than this
/// from what is below.
geom::Regions hanging_chains(const std::vector<Path>& paths, const geom::Regions& below,
                             const geom::Regions& bare, double widest_mm, double reach_mm) {
  std::optional<geom::AreaGrid> grid;  // made when first wanted
  const geom::Coord d = from_mm(kSliverMm);
  const auto firm = [&](const Point& p) {
    return grid->contains({p.x - d, p.y - d}, {p.x + d, p.y + d}) &&
           grid->contains({p.x - d, p.y + d}, {p.x + d, p.y - d});
  };
  const auto hangs = [&](const Point& p) {
    if (!grid) grid.emplace(quick_subtract(below, bare));
    if (firm(p)) return false;
    const double reach = kLeanShare * reach_mm * geom::kNmPerMm;
    for (int k = 0; k < kWays; ++k) {
      const double a = 2 * std::numbers::pi * k / kWays;
      if (firm({p.x + std::llround(reach * std::cos(a)), p.y + std::llround(reach * std::sin(a))}))
        return false;
    }
    return true;
  };
  std::multimap<std::pair<geom::Coord, geom::Coord>, const Path*> at;
  std::vector<const Path*> found;
  for (const Path& p : paths) {
    if (p.role != Role::gap_fill || p.closed || p.points.empty()) continue;
    for (const Point& q : {p.points.front(), p.points.back()}) at.emplace(std::pair(q.x, q.y), &p);
    if (p.width_mm <= widest_mm && (hangs(p.points.front()) || hangs(p.points.back()))) found.push_back(&p);
  }
  std::set<const Path*> known(found.begin(), found.end());
  geom::Rings boxes;
  for (std::size_t k = 0; k < found.size(); ++k) {  // grows
    const geom::Polyline& line = found[k]->points;
    const geom::Box box = grown(*geom::bounds(line), from_mm(kAroundMm));
    boxes.push_back(geom::make_rectangle(box.min, box.max));
    for (const Point& q : {line.front(), line.back()})
      for (auto [it, end] = at.equal_range({q.x, q.y}); it != end; ++it)
        if (known.insert(it->second).second) found.push_back(it->second);
  }
  return boxes.empty() ? geom::Regions{} : geom::unite(boxes);
}

/// What carries the lines of layer i there: the layer below without what of it is bare, lower ones over a gap
/// in which no support has room, and support.
geom::Regions ground_of(std::size_t i, const geom::Regions& where, const slice::LayerStack& stack,
                        const geom::Regions& support, const std::vector<geom::Regions>& bare,
                        const SliceSettings& s) {
  const geom::Coord sliver = from_mm(kSliverMm);
  geom::Regions over = quick_intersect(stack[i - 1].regions, where);  // no gap of the part's own
  geom::Regions out = geom::open(quick_subtract(over, bare[i - 1]), sliver);
  const slice::LayerSpan& span = stack[i].span;
  const double no_room = 2 * s.support_z_gap_mm + span.height_mm() - kStepMm;
  for (std::size_t j = i - 1; j-- > 0 && span.bottom_mm - stack[j].span.top_mm < no_room;) {
    const geom::Regions lower = quick_subtract(quick_intersect(stack[j].regions, where), over);
    if (lower.empty()) continue;
    out = quick_unite(out, geom::open(quick_subtract(lower, bare[j]), sliver));
    over = quick_unite(over, lower);
  }
  const double lean = lean_mm(s, span.height_mm());
  const geom::Regions held = quick_intersect(support, where);
  if (!held.empty())
    out = quick_unite(out, geom::offset(held, from_mm(std::max(kBesideSupportMm - lean, 0.0))));
  return geom::offset(out, from_mm(lean));
}

}  // namespace

geom::Regions cut_threads(std::vector<Path>& paths, const geom::Regions& ground, double widest_mm) {
  return Cutter(paths, ground, widest_mm).run();
}

void cut_threads(std::span<LayerPlan> layers, const slice::LayerStack& stack,
                 std::vector<geom::Regions>& bare, const SliceSettings& settings, const run::Context& ctx) {
  std::vector<geom::Regions> cut_off(layers.size());
  const double widest = widest_mm(settings);
  const auto cut = [&](std::size_t i) {
    const std::size_t bearer = layer_below_gap(stack, i, settings.support_z_gap_mm);
    if (bearer >= layers.size()) return;  // the plate is as near as a support would be
    const geom::Regions where = hanging_chains(layers[i].paths, stack[i - 1].regions, bare[i - 1], widest,
                                               lean_mm(settings, stack[i].span.height_mm()));
    if (where.empty()) return;
    const geom::Regions ground = ground_of(i, where, stack, layers[bearer].support, bare, settings);
    append(cut_off[i], Cutter(layers[i].paths, ground, widest, &where).run());
  };
  run::parallel_for(ctx, layers.size(), [&](std::size_t i) {
    if (i > 0 && stack[i].regions != stack[i - 1].regions) cut(i);
  });
  for (std::size_t i = 1; i < layers.size(); ++i) {
    if (cut_off[i - 1].empty()) continue;
    bare[i - 1] = quick_unite(bare[i - 1], geom::unite(geom::rings_of(cut_off[i - 1])));
    cut(i);
  }
}

}  // namespace voidpath::toolpath

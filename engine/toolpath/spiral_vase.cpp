#include "engine/toolpath/spiral_vase.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/build.h"
#include "engine/toolpath/fill_paths.h"
#include "engine/toolpath/outline.h"
#include "engine/toolpath/region_ops.h"
#include "engine/toolpath/walls/gap_lines.h"
#include "engine/toolpath/walls/perimeters.h"
#include "engine/toolpath/walls/sharp_corners.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Ring;

/// Contours further apart than this do not pass into one another, mm: the wall would hang in the air on its
/// way.
constexpr double kMaxBlendMm = 1.0;
/// What is too narrow for the wall and as large as a tip this long, mm, is printed by itself; less would cost
/// more in stops than it shows.
constexpr double kLeastFinMm = 0.6;
/// What is thinner than this is not there, mm.
constexpr double kLeastSheetMm = 0.04;
/// Of offsets that undo one another, nm.
constexpr geom::Coord kOffsetSlack = 1000;
/// Contours smaller than this around are not worth a spiral, mm: they print as they are.
constexpr double kMinRoundMm = 1.0;

struct Nearest {
  Point point;
  std::size_t edge = 0;  ///< from vertex `edge` to the next
  double distance = std::numeric_limits<double>::max();
};

Nearest nearest_on(const Ring& ring, const Point& p) {
  Nearest best;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point& a = ring[i];
    const Point& b = ring[(i + 1) % ring.size()];
    const auto dx = static_cast<double>(b.x - a.x);
    const auto dy = static_cast<double>(b.y - a.y);
    const double length2 = dx * dx + dy * dy;
    double t = 0;
    if (length2 > 0)
      t = std::clamp((static_cast<double>(p.x - a.x) * dx + static_cast<double>(p.y - a.y) * dy) / length2,
                     0.0, 1.0);
    const Point q{a.x + std::llround(t * dx), a.y + std::llround(t * dy)};
    const double d = geom::distance(p, q);
    if (d < best.distance) best = {q, i, d};
  }
  return best;
}

Point between(const Point& a, const Point& b, double t) {
  return {a.x + std::llround(t * static_cast<double>(b.x - a.x)),
          a.y + std::llround(t * static_cast<double>(b.y - a.y))};
}

/// Outer contours, filled.
geom::Regions filled(const geom::Regions& outline) {
  geom::Rings outers;
  for (const auto& region : outline) outers.push_back(region.outer);
  geom::Regions out = geom::unite(outers);
  for (auto& region : out) region.holes.clear();
  return out;
}

/// What one layer of the wall is: a single contour, or several.
struct VaseLayer {
  geom::Rings contours;
  geom::Regions fins;    ///< beside them, too narrow for a contour
  geom::Regions sheets;  ///< whole outlines too narrow for one
  Point end;             ///< of the round, on the contour

  VaseLayer() = default;
  VaseLayer(const geom::Regions& outline, double line_width_mm) {
    const geom::Coord half = from_mm(0.5 * line_width_mm);
    for (auto& region : filled(outline)) {
      geom::Regions inner = geom::offset({region}, -half);
      if (inner.empty()) {
        append(sheets, geom::open({region}, from_mm(0.5 * kLeastSheetMm)));
        continue;
      }
      for (auto& r : inner) r = {with_corners_out(r.outer, region, line_width_mm), {}};
      add_fins(region, inner, half);
      for (auto& r : inner) contours.push_back(std::move(r.outer));
    }
  }
  void add_fins(const geom::Region& region, const geom::Regions& inner, geom::Coord half) {
    const geom::Regions left = geom::open(quick_subtract({region}, geom::offset(inner, half + kOffsetSlack)),
                                          from_mm(0.5 * kLeastSheetMm));
    if (left.empty()) return;
    const geom::Coord least = from_mm(kLeastFinMm);
    const geom::Regions far = quick_subtract(left, geom::offset(inner, half + least));
    for (const auto& fin : left)
      if (geom::area(fin) >= static_cast<double>(least) * static_cast<double>(half) ||
          !quick_intersect({fin}, far).empty())
        fins.push_back(fin);
  }
  bool climbs() const {
    return contours.size() == 1 && geom::perimeter(contours.front()) >= kMinRoundMm * geom::kNmPerMm;
  }
};

Path wall_path(geom::Polyline&& points, bool closed, const BeadSize& bead) {
  return make_path(Role::external_perimeter, std::move(points), closed, bead.width_mm, bead.height_mm,
                   bead.area_mm2());
}

/// Layers are told apart by their walls alone from here on.
class Spiral {
 public:
  Spiral(const slice::LayerStack& stack, std::size_t bottoms, double lift_mm, const SliceSettings& settings,
         const run::Context& ctx)
      : stack_(stack), bottoms_(bottoms), lift_(lift_mm), settings_(settings), ctx_(ctx) {
    walls_.resize(stack.size());
    run::parallel_for(ctx, stack.size(), [&](std::size_t i) {
      walls_[i] = VaseLayer(stack[i].regions, settings.line_width_mm);
    });
    // Where a round ends, the next one begins.
    for (std::size_t i = 0; i < walls_.size(); ++i) {
      if (!walls_[i].climbs()) continue;
      const bool on = i > 0 && walls_[i - 1].climbs();
      walls_[i].end = on ? nearest_on(walls_[i].contours.front(), walls_[i - 1].end).point
                         : walls_[i].contours.front().front();
    }
  }

  std::vector<LayerPlan> run() const {
    std::vector<LayerPlan> out(stack_.size() - bottoms_);
    run::parallel_for(ctx_, out.size(), [&](std::size_t k) { out[k] = layer(k + bottoms_); });
    return out;
  }

 private:
  LayerPlan layer(std::size_t i) const {
    LayerPlan out;
    out.span = {stack_[i].span.bottom_mm + lift_, stack_[i].span.top_mm + lift_};
    out.outline = stack_[i].regions;
    const VaseLayer& wall = walls_[i];
    const BeadSize bead{settings_.line_width_mm, out.span.height_mm()};
    if (wall.climbs())
      add_round(out, i, bead);
    else
      for (const Ring& ring : wall.contours) out.paths.push_back(wall_path(Ring(ring), true, bead));
    // Level, at the height where the round has ended.
    add_thin_lines(out.paths, wall.fins, bead, settings_.resolution_mm);
    add_thin_lines(out.paths, wall.sheets, bead, settings_.resolution_mm);
    return out;
  }

  void add_round(LayerPlan& out, std::size_t i, const BeadSize& bead) const {
    const VaseLayer& wall = walls_[i];
    const bool climbed = i > bottoms_ && walls_[i - 1].climbs();
    const bool joined = walls_[i - 1].climbs();  // the layer below may be a bottom layer
    const Ring below = joined ? walls_[i - 1].contours.front() : Ring{};
    Path path =
        wall_path(vase_round(wall.contours.front(), below, wall.end, joined ? walls_[i - 1].end : wall.end),
                  false, bead);
    // A round lies on the one below, which climbed as well: its thickness goes from that one's to its own.
    const double first = climbed ? stack_[i - 1].span.height_mm() / out.span.height_mm() : 0.0;
    path.rise = Rise{out.span.bottom_mm, out.span.top_mm, first, 1.0};
    out.paths.push_back(std::move(path));
    if (i + 1 == stack_.size() || !walls_[i + 1].climbs()) {
      Path rim = wall_path(vase_round(wall.contours.front(), {}, wall.end, wall.end), false, bead);
      rim.rise = Rise{out.span.top_mm, out.span.top_mm, 1.0, 0.0};
      out.paths.push_back(std::move(rim));
    }
  }

  const slice::LayerStack& stack_;
  std::size_t bottoms_;
  double lift_;
  const SliceSettings& settings_;
  const run::Context& ctx_;
  std::vector<VaseLayer> walls_;
};

/// A place of a round, and the one on the contour below from which it has come.
struct Step {
  Point own, below;
  double way = 0;  ///< from the step before along the round, nm
};

/// Adds the corners of the contour below that lie between the feet of `a` and `b`, where the round goes
/// straight from one to the other: as long as the round has hardly left it, it must have its shape.
void add_corners(std::vector<Step>& steps, const Ring& below, const Nearest& from, const Nearest& to,
                 const Point& a, const Point& b) {
  const std::size_t n = below.size();
  const std::size_t corners = (to.edge + n - from.edge) % n;
  // Feet may go back a little where the round bends away.
  if (corners > n / 2) return;
  const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
  const double length = std::hypot(dx, dy);
  double gone = 0;
  for (std::size_t k = 1; k <= corners; ++k) {
    const Point& corner = below[(from.edge + k) % n];
    const double along =
        (static_cast<double>(corner.x - a.x) * dx + static_cast<double>(corner.y - a.y) * dy) / length;
    const double at = std::clamp(along, gone, length);
    const Point own = between(a, b, at / length);
    if (geom::distance(own, corner) > kMaxBlendMm * geom::kNmPerMm) continue;
    steps.push_back({own, corner, at - gone});
    gone = at;
  }
  steps.push_back({b, b, length - gone});
}

/// From the contour below to the round: all corners of the round but the first, and those of the contour
/// below. Where they are too far apart, a place comes from itself.
std::vector<Step> steps_from(const Ring& below, const geom::Polyline& round) {
  std::vector<Step> out;
  Nearest before = nearest_on(below, round.front());
  const auto close = [](const Nearest& foot) { return foot.distance <= kMaxBlendMm * geom::kNmPerMm; };
  for (std::size_t k = 1; k < round.size(); ++k) {
    const Nearest foot = nearest_on(below, round[k]);
    const std::size_t first = out.size();
    if (close(before) && close(foot)) add_corners(out, below, before, foot, round[k - 1], round[k]);
    if (out.size() == first) out.push_back({round[k], round[k], geom::distance(round[k - 1], round[k])});
    if (close(foot)) out.back().below = foot.point;
    before = foot;
  }
  return out;
}

}  // namespace

geom::Rings vase_contours(const geom::Regions& outline, double line_width_mm) {
  return VaseLayer(outline, line_width_mm).contours;
}

geom::Polyline vase_round(const Ring& ring, const Ring& below, const geom::Point& end,
                          const geom::Point& begin) {
  const Nearest from = nearest_on(ring, end);
  geom::Polyline round{from.point};
  for (std::size_t k = 1; k <= ring.size(); ++k) {
    const Point& p = ring[(from.edge + k) % ring.size()];
    if (p != round.back()) round.push_back(p);
  }
  if (round.back() != from.point) round.push_back(from.point);
  if (below.empty()) return round;
  if (geom::distance(begin, from.point) > kMaxBlendMm * geom::kNmPerMm) return round;
  geom::Polyline out{begin};
  const double length = geom::length(round);
  double along = 0;
  for (const Step& step : steps_from(below, round)) {
    along += step.way;
    const Point p = between(step.below, step.own, length > 0 ? along / length : 1);
    if (p != out.back()) out.push_back(p);
  }
  return out;
}

Plan build_vase(const slice::LayerStack& cuts, const PrintSettings& settings, const run::Context& ctx) {
  PrintSettings bottom = settings;
  SliceSettings& s = bottom.slice;
  s.spiral_vase = false;
  s.support = SupportMode::none;
  if (s.bottom_layers <= 0) {
    s.perimeters = 1;
    s.infill_density = 0;
    s.top_layers = 0;
  }
  const std::size_t bottoms = std::min(cuts.size(), static_cast<std::size_t>(std::max(s.bottom_layers, 1)));
  const slice::LayerStack floor(cuts.begin(), cuts.begin() + static_cast<std::ptrdiff_t>(bottoms));
  Plan plan = build(floor, bottom, ctx);
  if (bottoms == cuts.size()) return plan;
  const double lift = plan.layers.back().span.top_mm - floor.back().span.top_mm;
  const slice::LayerStack stack = outlines(cuts, s, ctx);
  std::vector<LayerPlan> spiral = Spiral(stack, bottoms, lift, s, ctx).run();
  plan.layers.insert(plan.layers.end(), std::make_move_iterator(spiral.begin()),
                     std::make_move_iterator(spiral.end()));
  return plan;
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/fill/lightning.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/fill/branches.h"
#include "engine/toolpath/fill/infill.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Regions;

/// What lies on nothing is looked at in points this far apart, as a share of the reach.
constexpr double kSampleShare = 0.5;
/// Points are to be held within this share of the reach, so that all between them are within the reach.
constexpr double kHoldShare = 0.64;
/// A wall or solid area holds what is this near to it, in line widths, and no further than the reach.
constexpr double kBorderWidths = 2.0;
/// Branches may lean by this from layer to layer, as a share of its height: 45°.
constexpr double kLean = 1.0;
/// Roots this near to the border in line widths are moved to it instead of joined by a line.
constexpr double kNearWidths = 1.0;
/// Strips that come out from the layer below by less than this share of a layer's height hold themselves:
/// 45°.
constexpr double kSelfHeld = 1.0;

/// Further than any way on a bed, nm.
constexpr double kAnywhereNm = 1e12;

class Lightning {
 public:
  Lightning(const std::vector<Surfaces>& surfaces, const slice::LayerStack& stack,
            const SliceSettings& settings, const run::Context& ctx)
      : surfaces_(surfaces),
        stack_(stack),
        settings_(settings),
        ctx_(ctx),
        reach_(lightning_reach_mm(settings) * geom::kNmPerMm) {}

  std::vector<geom::Polylines> run() {
    const std::size_t n = stack_.size();
    std::vector<geom::Polylines> out(n);
    if (settings_.infill_density <= 0) return out;
    domains_.resize(n);
    loads_.resize(n);
    run::parallel_for(ctx_, n, [&](std::size_t i) {
      const BeadSize bead = bead_of_layer(settings_, i, stack_[i].span.height_mm());
      domains_[i] = centre_line_area(surfaces_[i].sparse, bead, fill_overlap(settings_, bead));
      loads_[i] = load(i);
    });
    Branches branches;
    for (std::size_t i = n; i-- > 0;) {
      ctx_.check();
      grow(i, branches);
      out[i] = branches.lines();
    }
    return out;
  }

 private:
  /// What layer i must hold: sparse here and no longer above.
  Regions load(std::size_t i) const {
    const Regions& own = surfaces_[i].sparse;
    if (own.empty() || i + 1 >= stack_.size()) return own;
    const Regions over = quick_subtract(own, surfaces_[i + 1].sparse);
    if (over.empty()) return over;
    return geom::open(over, from_mm(0.5 * kSelfHeld * stack_[i + 1].span.height_mm()));
  }

  void grow(std::size_t i, Branches& branches) const {
    const Regions& domain = domains_[i];
    if (domain.empty() || (branches.empty() && loads_[i].empty())) {
      branches = {};
      return;
    }
    if (i + 1 < stack_.size()) branches.shrink(kLean * stack_[i + 1].span.height_mm() * geom::kNmPerMm);
    if (!branches.empty()) branches.clip(geom::AreaGrid(domain));
    if (branches.empty() && loads_[i].empty()) return;
    LineIndex border(grown(*geom::bounds(domain), 1), std::llround(reach_));
    for (const auto& ring : geom::rings_of(domain))
      for (std::size_t k = 0; k < ring.size(); ++k) border.add(ring[k], ring[(k + 1) % ring.size()]);
    branches.ground(border, kNearWidths * settings_.line_width_mm * geom::kNmPerMm);
    if (!loads_[i].empty()) hold(loads_[i], border, branches);
    branches.sort();
  }

  /// Adds branches until every part of the load is within reach of one.
  void hold(const Regions& load, const LineIndex& border, Branches& branches) const {
    const double within = kHoldShare * reach_;
    const double by_border = std::min(kBorderWidths * settings_.line_width_mm * geom::kNmPerMm, within);
    std::vector<std::pair<double, Point>> points;  // distance to the border
    for (const Point& p : samples(load)) {
      const double d = border.nearest(p, kAnywhereNm).distance;
      if (d > by_border) points.emplace_back(d, p);
    }
    // From the middle out: long straight branches first, and what they hold needs no others.
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    LineIndex lines(border.box(), std::llround(reach_));
    std::vector<std::uint32_t> line_nodes;
    branches.index(lines, line_nodes);
    for (const auto& [d, p] : points)
      if (lines.nearest(p, within).distance > within) branches.connect(p, border, lines, line_nodes);
  }

  /// Points of the area on a lattice, and along its border for what falls between.
  std::vector<Point> samples(const Regions& area) const {
    std::vector<Point> out;
    const auto step = std::max<geom::Coord>(std::llround(kSampleShare * reach_), 1000);
    for (const geom::Region& region : area) {
      const geom::AreaGrid grid({region});
      const auto box = *geom::bounds(region.outer);
      auto first = [&](geom::Coord c) { return (c >= 0 ? c / step : -((-c + step - 1) / step)) * step; };
      for (geom::Coord y = first(box.min.y); y <= box.max.y; y += step)
        for (geom::Coord x = first(box.min.x); x <= box.max.x; x += step)
          if (grid.contains({x, y})) out.push_back({x, y});
      for (const auto& ring : geom::rings_of({region}))
        for (std::size_t k = 0; k < ring.size(); ++k) {
          const Point &a = ring[k], &b = ring[(k + 1) % ring.size()];
          const auto parts = static_cast<geom::Coord>(geom::distance(a, b) / static_cast<double>(step)) + 1;
          for (geom::Coord j = 0; j < parts; ++j)
            out.push_back({a.x + (b.x - a.x) * j / parts, a.y + (b.y - a.y) * j / parts});
        }
    }
    return out;
  }

  const std::vector<Surfaces>& surfaces_;
  const slice::LayerStack& stack_;
  const SliceSettings& settings_;
  const run::Context& ctx_;
  double reach_;  ///< nm
  std::vector<Regions> domains_;
  std::vector<Regions> loads_;
};

}  // namespace

double lightning_reach_mm(const SliceSettings& settings) {
  return 0.5 * settings.line_width_mm / std::clamp(settings.infill_density, 0.01, 1.0);
}

std::vector<geom::Polylines> lightning_lines(const std::vector<Surfaces>& surfaces,
                                             const slice::LayerStack& stack, const SliceSettings& settings,
                                             const run::Context& ctx) {
  return Lightning(surfaces, stack, settings, ctx).run();
}

}  // namespace voidpath::toolpath

#include "engine/toolpath/support/tree_room.h"

#include "engine/geom/polygon_ops.h"
#include "engine/run/parallel_for.h"
#include "engine/toolpath/region_ops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace voidpath::toolpath {

namespace {

using geom::from_mm;
using geom::Point;
using geom::Regions;
using Shared = std::shared_ptr<const Regions>;

/// Forbidden areas are simplified to this and grown by as much, mm: they are offset many times.
constexpr double kToleranceMm = 0.05;
/// A branch that is moved out of an area is put this far beyond its border, nm, so that rounding does not
/// put it back.
constexpr double kBeyondNm = 2000;
/// Half of a circle's width must lie on the part for a branch to stand there; its middle keeps this share
/// of its radius from the edge.
constexpr double kRestInset = 0.5;

Shared share(Regions&& regions) { return std::make_shared<const Regions>(std::move(regions)); }

Point nearest_on_edge(const Point& a, const Point& b, const Point& p) {
  const auto dx = static_cast<double>(b.x - a.x);
  const auto dy = static_cast<double>(b.y - a.y);
  const double length2 = dx * dx + dy * dy;
  if (length2 <= 0) return a;
  const double t = std::clamp(
      (static_cast<double>(p.x - a.x) * dx + static_cast<double>(p.y - a.y) * dy) / length2, 0.0, 1.0);
  return {a.x + std::llround(t * dx), a.y + std::llround(t * dy)};
}

/// The nearest point of the borders that is nearer than `limit`.
std::optional<std::pair<Point, double>> nearest_border(const Regions& regions, const Point& p, double limit) {
  std::optional<std::pair<Point, double>> best;
  const auto visit = [&](const geom::Ring& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[i + 1 == ring.size() ? 0 : i + 1];
      const double out = std::max(
          {static_cast<double>(std::min(a.x, b.x) - p.x), static_cast<double>(p.x - std::max(a.x, b.x)),
           static_cast<double>(std::min(a.y, b.y) - p.y), static_cast<double>(p.y - std::max(a.y, b.y))});
      if (out >= limit) continue;
      const Point q = nearest_on_edge(a, b, p);
      const double d = geom::distance(p, q);
      if (d >= limit) continue;
      limit = d;
      best = std::pair{q, d};
    }
  };
  for (const auto& region : regions) {
    visit(region.outer);
    for (const auto& hole : region.holes) visit(hole);
  }
  return best;
}

}  // namespace

TreeRoom::TreeRoom(const slice::LayerStack& stack, const SupportTask& task, std::size_t top,
                   const SliceSettings& settings, const run::Context& ctx)
    : layers_(top + 1), on_part_(settings.support == SupportMode::everywhere) {
  const double lean =
      std::tan(std::clamp(settings.tree_branch_angle_deg, 1.0, 80.0) * std::numbers::pi / 180);
  for (std::size_t i = 0; i <= top; ++i) step_.push_back(stack[i].span.height_mm() * lean * geom::kNmPerMm);
  const double tip = 0.5 * settings.tree_tip_diameter_mm;
  find_collisions(task, tip, ctx);
  if (on_part_) find_rests(stack, settings, tip, ctx);
  climb(ctx);
  run::parallel_for(ctx, layers_.size(), [&](std::size_t i) {
    Layer& layer = layers_[i];
    layer.lost_grid = std::make_unique<geom::AreaGrid>(*layer.lost);
    if (!on_part_) return;
    layer.doomed_grid = std::make_unique<geom::AreaGrid>(*layer.doomed);
    layer.rest_grid = std::make_unique<geom::AreaGrid>(*layer.rest);
  });
}

void TreeRoom::find_collisions(const SupportTask& task, double tip_radius_mm, const run::Context& ctx) {
  const auto as_below = [&](std::size_t i) { return i > 0 && task.forbidden[i] == task.forbidden[i - 1]; };
  run::parallel_for(ctx, layers_.size(), [&](std::size_t i) {
    if (as_below(i)) return;
    layers_[i].forbidden = share(geom::simplify(task.forbidden[i], from_mm(kToleranceMm)));
    layers_[i].collision =
        share(geom::simplify(geom::offset(*layers_[i].forbidden, from_mm(tip_radius_mm + 2 * kToleranceMm)),
                             from_mm(kToleranceMm)));
  });
  for (std::size_t i = 1; i < layers_.size(); ++i) {
    if (layers_[i].forbidden) continue;
    layers_[i].forbidden = layers_[i - 1].forbidden;
    layers_[i].collision = layers_[i - 1].collision;
  }
}

void TreeRoom::find_rests(const slice::LayerStack& stack, const SliceSettings& settings, double tip_radius_mm,
                          const run::Context& ctx) {
  run::parallel_for(ctx, layers_.size(), [&](std::size_t i) {
    Regions rest;
    const std::size_t below = layer_below_gap(stack, i, settings.support_z_gap_mm);
    if (below < stack.size())
      rest = quick_subtract(geom::offset(geom::simplify(stack[below].regions, from_mm(kToleranceMm)),
                                         -from_mm(kRestInset * tip_radius_mm)),
                            *layers_[i].collision);
    layers_[i].rest = share(std::move(rest));
  });
}

/// A place is lost when it collides, or when every place in the layer below that a branch could move to is
/// lost: what is lost there, shrunk by a step.
void TreeRoom::climb(const run::Context& ctx) {
  for (std::size_t i = 0; i < layers_.size(); ++i) {
    ctx.check();
    Layer& layer = layers_[i];
    if (i == 0) {
      layer.lost = layer.doomed = layer.collision;
      continue;
    }
    const Layer& below = layers_[i - 1];
    const bool settled = layer.collision == below.collision;
    const geom::Coord step = from_mm(step_[i] / geom::kNmPerMm);
    const auto rise = [&](const Shared& lost, const Regions* rest) {
      if (settled && lost == below.collision) return layer.collision;
      Regions sunk = geom::offset(*lost, -step);
      if (rest != nullptr) sunk = quick_subtract(sunk, *rest);
      return share(geom::simplify(quick_unite(*layer.collision, sunk), from_mm(0.2 * kToleranceMm)));
    };
    layer.lost = rise(below.lost, nullptr);
    if (on_part_) layer.doomed = rise(below.doomed, layer.rest.get());
  }
}

bool TreeRoom::reaches_plate(std::size_t layer, const Point& p) const {
  return !layers_[layer].lost_grid->contains(p);
}

bool TreeRoom::reaches_anything(std::size_t layer, const Point& p) const {
  if (!on_part_) return reaches_plate(layer, p);
  return !layers_[layer].doomed_grid->contains(p);
}

bool TreeRoom::rests(std::size_t layer, const Point& p) const {
  return on_part_ && layers_[layer].rest_grid->contains(p);
}

std::optional<Point> TreeRoom::nearest(std::size_t layer, const Point& p, bool plate, double within) const {
  const auto good = [&](const Point& q) {
    return plate ? reaches_plate(layer, q) : reaches_anything(layer, q);
  };
  if (good(p)) return p;
  const Regions& bad = plate || !on_part_ ? *layers_[layer].lost : *layers_[layer].doomed;
  const auto border = nearest_border(bad, p, within);
  if (!border) return {};
  const double d = std::max(border->second, 1.0);
  const double beyond = (d + kBeyondNm) / d;
  const Point out{p.x + std::llround(static_cast<double>(border->first.x - p.x) * beyond),
                  p.y + std::llround(static_cast<double>(border->first.y - p.y) * beyond)};
  if (good(out)) return out;
  return {};
}

TreeRoom::Clearance TreeRoom::clearance(std::size_t layer, const Point& p, double limit) const {
  const auto border = nearest_border(*layers_[layer].forbidden, p, limit + kToleranceMm * geom::kNmPerMm);
  if (!border) return {limit, p};
  return {std::max(0.0, border->second - kToleranceMm * geom::kNmPerMm), border->first};
}

}  // namespace voidpath::toolpath

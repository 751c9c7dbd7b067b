#pragma once

#include "engine/geom/polygon.h"
#include "engine/geom/polygon_ops.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/build.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"

#include <functional>
#include <vector>

/// Stacks of layers made by hand, whose areas are known, and measures of plans.
namespace voidpath::test {

inline geom::Region rectangle(double x0, double y0, double x1, double y1) {
  using geom::from_mm;
  return {geom::make_rectangle({from_mm(x0), from_mm(y0)}, {from_mm(x1), from_mm(y1)}), {}};
}

/// Layers of equal height whose areas `at(middle height)` gives.
inline slice::LayerStack stack_of(double height_mm, double layer_mm,
                                  const std::function<geom::Regions(double)>& at) {
  slice::LayerStack out;
  const auto n = static_cast<std::size_t>(height_mm / layer_mm + 0.5);
  for (std::size_t i = 0; i < n; ++i) {
    slice::Layer layer;
    layer.span = {static_cast<double>(i) * layer_mm, static_cast<double>(i + 1) * layer_mm};
    layer.regions = at(layer.span.cut_mm());
    out.push_back(std::move(layer));
  }
  return out;
}

inline slice::LayerStack box_stack(double x, double y, double z, double layer = 0.2) {
  return stack_of(z, layer, [=](double) { return geom::Regions{rectangle(50, 50, 50 + x, 50 + y)}; });
}

/// A plate from `height - plate` up, on two legs along y at its ends in x: what is between is a bridge.
inline slice::LayerStack arch_stack(double x, double y, double height, double plate, double leg) {
  return stack_of(height, 0.2, [=](double z) {
    if (z > height - plate) return geom::Regions{rectangle(50, 50, 50 + x, 50 + y)};
    return geom::Regions{rectangle(50, 50, 50 + leg, 50 + y), rectangle(50 + x - leg, 50, 50 + x, 50 + y)};
  });
}

/// A square plate on one post in its middle: overhangs on all sides, nothing to bridge to.
inline slice::LayerStack mushroom_stack(double size, double height, double plate, double post) {
  return stack_of(height, 0.2, [=](double z) {
    const double half = 0.5 * (z > height - plate ? size : post);
    return geom::Regions{rectangle(80 - half, 80 - half, 80 + half, 80 + half)};
  });
}

/// Open-top box.
inline slice::LayerStack cup_stack(double size, double height, double wall, double floor) {
  return stack_of(height, 0.2, [=](double z) {
    geom::Region r = rectangle(50, 50, 50 + size, 50 + size);
    if (z > floor) {
      geom::Ring hole = rectangle(50 + wall, 50 + wall, 50 + size - wall, 50 + size - wall).outer;
      geom::reverse(hole);
      r.holes.push_back(hole);
    }
    return geom::Regions{r};
  });
}

/// Cone standing on its base, `sides` corners.
inline slice::LayerStack cone_stack(double radius, double height, double top_radius, int sides = 48) {
  return stack_of(height, 0.2, [=](double z) {
    const double r = radius + (top_radius - radius) * z / height;
    return geom::Regions{
        {geom::make_circle({geom::from_mm(80), geom::from_mm(80)}, geom::from_mm(r), sides), {}}};
  });
}

inline double length_mm(const toolpath::Path& path) {
  double sum = geom::length(path.points);
  if (path.closed) sum += geom::distance(path.points.back(), path.points.front());
  return sum / geom::kNmPerMm;
}

inline double volume_mm3(const toolpath::Path& path) { return length_mm(path) * path.area_mm2; }

inline double volume_mm3(const toolpath::Plan& plan) {
  double sum = 0;
  for (const auto& layer : plan.layers)
    for (const auto& path : layer.paths) sum += volume_mm3(path);
  return sum;
}

inline std::size_t count(const toolpath::LayerPlan& layer, toolpath::Role role) {
  std::size_t n = 0;
  for (const auto& path : layer.paths) n += path.role == role ? 1 : 0;
  return n;
}

inline geom::Polyline line_of(const toolpath::Path& path) {
  geom::Polyline line = path.points;
  if (path.closed) line.push_back(line.front());
  return line;
}

/// Settings without what surrounds the part, so that laws can be about the part alone.
inline toolpath::PrintSettings bare_settings() {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  s.slice.support = toolpath::SupportMode::none;
  return s;
}

/// The area the beads cover: lines widened by half their width.
inline geom::Regions covered(const toolpath::LayerPlan& layer,
                             const std::function<bool(const toolpath::Path&)>& which, double extra_mm = 0) {
  geom::Rings rings;
  for (const auto& path : layer.paths) {
    if (!which(path)) continue;
    const geom::Polyline line = line_of(path);
    const double half = path.width_mm / 2 + extra_mm;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const double dx = geom::to_mm(line[i + 1].x - line[i].x);
      const double dy = geom::to_mm(line[i + 1].y - line[i].y);
      const double d = std::hypot(dx, dy);
      if (d <= 0) continue;
      const double ux = dx / d * half;
      const double uy = dy / d * half;
      auto corner = [&](const geom::Point& p, double a, double b) {
        return geom::Point{p.x + geom::from_mm(a), p.y + geom::from_mm(b)};
      };
      rings.push_back({corner(line[i], uy - ux, -ux - uy), corner(line[i + 1], uy + ux, -ux + uy),
                       corner(line[i + 1], -uy + ux, ux + uy), corner(line[i], -uy - ux, ux - uy)});
    }
  }
  return geom::unite(rings);
}

}  // namespace voidpath::test

#include "engine/toolpath/fill/lightning.h"

#include "engine/toolpath/draft.h"
#include "tests/engine/toolpath/shapes.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::InfillPattern;
using toolpath::Role;

namespace {

double to_line(const geom::Point& p, const geom::Polyline& line) {
  double best = 1e300;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const auto dx = static_cast<double>(line[i + 1].x - line[i].x),
               dy = static_cast<double>(line[i + 1].y - line[i].y);
    const auto px = static_cast<double>(p.x - line[i].x), py = static_cast<double>(p.y - line[i].y);
    const double len2 = dx * dx + dy * dy;
    const double t = len2 > 0 ? std::clamp((px * dx + py * dy) / len2, 0.0, 1.0) : 0;
    best = std::min(best, std::hypot(px - t * dx, py - t * dy));
  }
  return best / geom::kNmPerMm;
}

/// From what the paths of the given kind print, in mm.
double to_paths(const geom::Point& p, const toolpath::LayerPlan& layer, bool lightning) {
  double best = 1e300;
  for (const auto& path : layer.paths)
    if ((path.role == Role::infill) == lightning) best = std::min(best, to_line(p, line_of(path)));
  return best;
}

double infill_mm(const toolpath::LayerPlan& layer) {
  double sum = 0;
  for (const auto& p : layer.paths)
    if (p.role == Role::infill) sum += length_mm(p);
  return sum;
}

toolpath::PrintSettings lightning_settings() {
  auto s = bare_settings();
  s.slice.infill_pattern = InfillPattern::lightning;
  return s;
}

/// A tall box with a roof in half its height over one half: two tops.
slice::LayerStack terrace_stack() {
  return stack_of(40, 0.2, [](double z) {
    return geom::Regions{z < 20 ? rectangle(50, 50, 90, 80) : rectangle(50, 50, 70, 80)};
  });
}

slice::LayerStack dome_stack() {
  return stack_of(18, 0.2, [](double z) {
    const double r = std::sqrt(20.0 * 20.0 - z * z);
    return geom::Regions{{geom::make_circle({from_mm(80), from_mm(80)}, from_mm(r), 90), {}}};
  });
}

}  // namespace

TEST_CASE("lightning holds every point of every top") {
  auto s = lightning_settings();
  const double reach = toolpath::lightning_reach_mm(s.slice);
  std::size_t looked_at = 0;
  for (const auto& stack : {box_stack(50, 40, 12), terrace_stack(), dome_stack()}) {
    const auto plan = toolpath::build(stack, s);
    for (std::size_t i = 1; i < plan.layers.size(); ++i)
      for (const auto& path : plan.layers[i].paths) {
        if (path.role != Role::internal_bridge) continue;
        const auto line = line_of(path);
        for (std::size_t k = 0; k + 1 < line.size(); ++k)
          for (double t = 0; t < 1; t += 0.05) {
            const geom::Point p{line[k].x + std::llround(t * static_cast<double>(line[k + 1].x - line[k].x)),
                                line[k].y + std::llround(t * static_cast<double>(line[k + 1].y - line[k].y))};
            const double d =
                std::min(to_paths(p, plan.layers[i - 1], true), to_paths(p, plan.layers[i - 1], false));
            if (d > reach + 0.05) {
              CAPTURE(i, geom::to_mm(p.x), geom::to_mm(p.y), d);
              CHECK(d <= reach + 0.05);
            }
            ++looked_at;
          }
      }
  }
  CHECK(looked_at > 5000);
}

TEST_CASE("branches stand on branches, and are gone a width below the top") {
  auto s = lightning_settings();
  for (const auto& stack : {box_stack(40, 30, 40), terrace_stack(), dome_stack()}) {
    const auto plan = toolpath::build(stack, s);
    double loose = 0, all = 0;
    for (std::size_t i = 1; i < plan.layers.size(); ++i) {
      geom::Polylines lines;
      for (const auto& p : plan.layers[i].paths)
        if (p.role == Role::infill) lines.push_back(line_of(p));
      if (lines.empty()) continue;
      const auto held = covered(
          plan.layers[i - 1], [](const auto&) { return true; }, 0.25);
      for (const auto& l : lines) all += geom::length(l);
      for (const auto& l : geom::clip_outside(lines, held)) loose += geom::length(l);
    }
    CHECK(all > 0);
    CHECK(loose < 0.02 * all);
  }
  const auto plan = toolpath::build(box_stack(40, 30, 40), s);
  // A branch leans by 45°, and none is longer than the part is wide.
  for (std::size_t i = 0; i < 40 * 5 - 5 - 30 * 5; ++i) CHECK(infill_mm(plan.layers[i]) == 0);
  CHECK(infill_mm(plan.layers[193]) > 100);
}

TEST_CASE("lightning takes far less than a lattice that holds the same top") {
  auto s = lightning_settings();
  auto total = [&] {
    double sum = 0;
    for (const auto& layer : toolpath::build(terrace_stack(), s).layers) sum += infill_mm(layer);
    return sum;
  };
  const double lightning = total();
  s.slice.infill_pattern = InfillPattern::rectilinear;
  CHECK(lightning > 0);
  CHECK(lightning < 0.35 * total());
}

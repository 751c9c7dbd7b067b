#include "engine/toolpath/fill/infill.h"

#include "engine/toolpath/bead.h"
#include "engine/toolpath/fill/fill_directions.h"
#include "engine/toolpath/fill/hatch.h"
#include "tests/engine/toolpath/shapes.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::InfillPattern;

namespace {

/// A star with a hole: borders in every direction, concave and convex.
geom::Region star(double radius) {
  geom::Region r;
  for (int i = 0; i < 14; ++i) {
    const double a = 2 * std::numbers::pi * i / 14;
    const double d = i % 2 == 0 ? radius : 0.55 * radius;
    r.outer.push_back({from_mm(60 + d * std::cos(a)), from_mm(60 + d * std::sin(a))});
  }
  geom::Ring hole = geom::make_circle({from_mm(60), from_mm(60)}, from_mm(0.2 * radius), 20);
  geom::reverse(hole);
  r.holes.push_back(hole);
  return r;
}

double total_mm(const geom::Polylines& lines) {
  double sum = 0;
  for (const auto& l : lines) sum += geom::length(l);
  return sum / geom::kNmPerMm;
}

}  // namespace

TEST_CASE("lines without links cover the area: length times spacing") {
  const geom::Region region = star(20);
  const double area = geom::to_mm2(geom::area(region));
  for (const double angle : {0.0, 0.3, 0.7853981633974483, 1.5707963267948966, 2.5}) {
    const auto h = toolpath::hatch({region}, {angle, 0.4, false, 0});
    CHECK(total_mm(h.lines) * 0.4 == Approx(area).epsilon(0.01));
    CHECK(geom::clip_outside(h.lines, geom::offset({region}, 2000)).empty());
  }
}

TEST_CASE("links follow the border and make far fewer lines of the same rows") {
  const geom::Region region = star(20);
  const auto apart = toolpath::hatch({region}, {0.6, 0.5, true, 0});
  const auto joined = toolpath::hatch({region}, {0.6, 0.5, true, 3});
  CHECK(joined.lines.size() * 5 < apart.lines.size());
  CHECK(total_mm(joined.lines) > total_mm(apart.lines));
  CHECK(geom::clip_outside(joined.lines, geom::offset({region}, 2000)).empty());
}

TEST_CASE("fitted rows reach from border to border") {
  const auto h = toolpath::hatch({rectangle(0, 0, 10, 10)}, {0, 0.3, true, 0});
  REQUIRE(h.lines.size() > 2);
  CHECK(geom::to_mm(h.lines.front().front().y) == Approx(0).margin(0.002));
  CHECK(geom::to_mm(h.lines.back().front().y) == Approx(10).margin(0.002));
  CHECK(h.spacing_mm == Approx(0.3).epsilon(0.16));
  // Where they may not be stretched, they are squeezed.
  for (double width = 1.0; width < 4.0; width += 0.07) {
    const auto dense = toolpath::hatch({rectangle(0, 0, 10, width)}, {0, 0.3, true, 0, 1.0});
    CHECK(dense.spacing_mm <= 0.3 + 1e-9);
    CHECK(dense.spacing_mm > 0.2);
    CHECK(geom::to_mm(dense.lines.back().front().y) == Approx(width).margin(0.002));
  }
}

TEST_CASE("every pattern keeps inside and honours the density") {
  const geom::Region region = rectangle(10, 10, 110, 90);
  const toolpath::BeadSize bead{0.45, 0.2};
  for (const auto pattern :
       {InfillPattern::rectilinear, InfillPattern::grid, InfillPattern::concentric, InfillPattern::gyroid})
    for (const double density : {0.1, 0.2, 0.4}) {
      toolpath::SliceSettings s;
      s.infill_pattern = pattern;
      s.infill_density = density;
      CAPTURE(static_cast<int>(pattern), density);
      double volume = 0;
      const int layers = 40;
      for (int i = 0; i < layers; ++i) {
        const slice::LayerSpan span{i * 0.2, (i + 1) * 0.2};
        const auto fill =
            toolpath::sparse_fill(region, s, (i % 2 == 0 ? 0.25 : 0.75) * std::numbers::pi, span, bead);
        CHECK(geom::clip_outside(fill.lines, geom::offset({region}, 3000)).empty());
        volume += total_mm(fill.lines) * fill.spacing_mm * 0.2;
        if (fill.closed)
          for (const auto& l : fill.lines)
            volume += geom::distance(l.front(), l.back()) / geom::kNmPerMm * fill.spacing_mm * 0.2;
      }
      const double share = volume / (100.0 * 80.0 * 0.2 * layers);
      CHECK(share > 0.93 * density);
      CHECK(share < 1.15 * density);
    }
}

TEST_CASE("the gyroid's cut solves its equation") {
  const geom::Box box{{0, 0}, {from_mm(20), from_mm(20)}};
  const double period = 7.0;
  const double unit = 2 * std::numbers::pi / period;
  std::size_t checked = 0;
  for (double z = 0.1; z < period; z += 0.37)
    for (const auto& line : toolpath::gyroid_lines(box, z, period))
      for (const auto& p : line) {
        const double x = geom::to_mm(p.x) * unit;
        const double y = geom::to_mm(p.y) * unit;
        const double w = z * unit;
        const double f = std::sin(x) * std::cos(y) + std::sin(y) * std::cos(w) + std::sin(w) * std::cos(x);
        CHECK(std::abs(f) < 1e-4);
        ++checked;
      }
  CHECK(checked > 1000);
}

TEST_CASE("beads: area, spacing and width belong together") {
  using namespace toolpath;
  CHECK(bead_area_mm2(0.45, 0.2) == Approx((0.45 - 0.2 * (1 - std::numbers::pi / 4)) * 0.2));
  CHECK(bead_area_mm2(0.2, 0.2) == Approx(std::numbers::pi / 4 * 0.04));
  CHECK(width_of_spacing_mm(bead_spacing_mm(0.5, 0.25), 0.25) == Approx(0.5));
  CHECK(strand_area_mm2(0.4) == Approx(std::numbers::pi * 0.04));
}

TEST_CASE("infill of several layers is printed at once, as thick as the nozzle allows") {
  auto s = bare_settings();
  s.slice.infill_every_layers = 3;
  for (const double layer : {0.1, 0.15, 0.2}) {
    const auto stack = box_stack(40, 30, 8, layer);
    const auto plan = toolpath::build(stack, s);
    const int at_once = std::min(3, static_cast<int>(s.machine.nozzle_mm / layer + 1e-6));
    auto plain = s;
    plain.slice.infill_every_layers = 1;
    const auto each = toolpath::build(stack, plain);
    double volume = 0, volume_each = 0;
    std::size_t with = 0, with_each = 0;
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
      with += count(plan.layers[i], toolpath::Role::infill) > 0 ? 1U : 0U;
      with_each += count(each.layers[i], toolpath::Role::infill) > 0 ? 1U : 0U;
      for (const auto& p : plan.layers[i].paths)
        if (p.role == toolpath::Role::infill) {
          volume += volume_mm3(p);
          CHECK(p.height_mm <= s.machine.nozzle_mm + 1e-6);
        }
      for (const auto& p : each.layers[i].paths)
        if (p.role == toolpath::Role::infill) volume_each += volume_mm3(p);
    }
    CAPTURE(layer, at_once, with, with_each);
    CHECK(static_cast<double>(with) == Approx(static_cast<double>(with_each) / at_once).margin(2.1));
    CHECK(volume == Approx(volume_each).epsilon(0.06));
  }
}

TEST_CASE("the way lines run: as set, soonest for the part, soonest for each solid layer") {
  using toolpath::InfillDirection;
  // Longer lines are sooner printed: along a strip.
  for (const double turn : {0.0, 0.5, 2.0}) {
    geom::Ring strip;
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {60.0, 0.0}, {60.0, 8.0}, {0.0, 8.0}})
      strip.push_back({from_mm(80 + x * std::cos(turn) - y * std::sin(turn)),
                       from_mm(80 + x * std::sin(turn) + y * std::cos(turn))});
    const geom::Regions area{{strip, {}}};
    CHECK(toolpath::seconds_of_lines(area, turn, 0.45, 80, 1000) <
          0.65 * toolpath::seconds_of_lines(area, turn + std::numbers::pi / 2, 0.45, 80, 1000));
  }
  // 100 lines of 40 mm from rest to rest: 40 mm / 80 mm/s + 80 mm/s / 1000 mm/s² each.
  CHECK(toolpath::seconds_of_lines({rectangle(0, 0, 40, 45)}, 0, 0.45, 80, 1000) ==
        Approx(100 * (0.5 + 0.08)).epsilon(0.03));
  // A sliver two nanometres wide is judged by lines as far apart as any: not by fifty million of them.
  const geom::Regions sliver{{geom::make_rectangle({0, 0}, {from_mm(100), 2}), {}}};
  const double across = toolpath::seconds_of_lines(sliver, std::numbers::pi / 2, 0.45, 80, 1000);
  CHECK(std::isfinite(across));
  CHECK(across < 1);

  auto s = bare_settings();
  std::vector<toolpath::Surfaces> layers(10);
  for (auto& layer : layers) layer.solid = {rectangle(0, 0, 60, 8)};
  auto degrees = [&](std::size_t i) {
    return toolpath::choose_directions(layers, s, {})[i].solid * 180 / std::numbers::pi;
  };
  CHECK(degrees(0) == Approx(45));
  CHECK(degrees(1) == Approx(135));
  s.slice.infill_direction = InfillDirection::layer;
  const auto directions = toolpath::choose_directions(layers, s, {});
  std::size_t along = 0;
  for (std::size_t i = 0; i + 1 < directions.size(); ++i) {
    CHECK(std::abs(std::sin(directions[i + 1].solid - directions[i].solid)) > 0.7);
    along += std::abs(std::sin(directions[i].solid)) < 0.1 ? 1U : 0U;
  }
  CHECK(along >= 4);
  s.slice.infill_direction = InfillDirection::part;
  for (std::size_t i = 0; i + 1 < layers.size(); ++i)
    CHECK(std::abs(std::cos((degrees(i + 1) - degrees(i)) * std::numbers::pi / 180)) < 1e-9);
}

#include "engine/toolpath/walls/gap_fill.h"

#include "engine/toolpath/bead.h"
#include "engine/toolpath/walls/border.h"
#include "engine/toolpath/walls/gap_lines.h"
#include "engine/toolpath/walls/triangulate.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;

namespace {

double triangle_area_mm2(const toolpath::Triangulation& t) {
  double sum = 0;
  for (const auto& tri : t.triangles)
    sum += geom::area(geom::Ring{t.points[tri.corner[0]], t.points[tri.corner[1]], t.points[tri.corner[2]]});
  return geom::to_mm2(sum);
}

geom::Region ring_area(double radius, double width) {
  geom::Region r{geom::make_circle({}, from_mm(radius + width / 2), 96),
                 {geom::make_circle({}, from_mm(radius - width / 2), 96)}};
  geom::reverse(r.holes[0]);
  return r;
}

double volume_per_height(const std::vector<toolpath::CentreLine>& lines) {
  double sum = 0;
  for (const auto& line : lines)
    for (std::size_t i = 0; i + 1 < line.points.size(); ++i)
      sum += geom::distance(line.points[i], line.points[i + 1]) / geom::kNmPerMm * 0.5 *
             (line.width_mm[i] + line.width_mm[i + 1]);
  return sum;
}

}  // namespace

TEST_CASE("a triangulation covers its region exactly and only with positive triangles") {
  geom::Region square = rectangle(0, 0, 10, 10);
  for (const double x : {1.0, 4.0, 7.0}) {
    geom::Ring hole = rectangle(x, 2, x + 1.5, 7).outer;
    geom::reverse(hole);
    square.holes.push_back(hole);
  }
  for (const geom::Region& region : {rectangle(0, 0, 20, 0.3), ring_area(5, 0.4), square}) {
    const auto t = toolpath::triangulate(region);
    CHECK(triangle_area_mm2(t) == Approx(geom::to_mm2(geom::area(region))).epsilon(1e-9));
    for (const auto& tri : t.triangles)
      CHECK(geom::area(
                geom::Ring{t.points[tri.corner[0]], t.points[tri.corner[1]], t.points[tri.corner[2]]}) >= 0);
  }
}

TEST_CASE("a strip's centre line runs down its middle with its width") {
  for (const double width : {0.2, 0.5, 0.9}) {
    const auto lines = toolpath::centre_lines(rectangle(0, 0, 20, width));
    REQUIRE(lines.size() == 1);
    for (std::size_t i = 0; i < lines[0].points.size(); ++i) {
      // At its ends, where the strip's corners meet, the line may be off by a little.
      const double x = geom::to_mm(lines[0].points[i].x);
      const bool at_end = x < width || x > 20 - width;
      CHECK(geom::to_mm(lines[0].points[i].y) == Approx(width / 2).margin(at_end ? 0.06 * width : 1e-5));
      CHECK(lines[0].width_mm[i] == Approx(width).epsilon(0.02));
    }
    const double length = geom::length(lines[0].points) / geom::kNmPerMm;
    CHECK(length <= 20);
    CHECK(length >= 20 - 2 * 0.4);
  }
}

TEST_CASE("a thin ring's centre line is closed and takes up its area") {
  const geom::Region region = ring_area(8, 0.4);
  const auto lines = toolpath::centre_lines(region);
  REQUIRE(lines.size() == 1);
  CHECK(lines[0].closed);
  CHECK(lines[0].points.front() == lines[0].points.back());
  CHECK(volume_per_height(lines) == Approx(geom::to_mm2(geom::area(region))).epsilon(0.03));
}

TEST_CASE("thin walls of every width are printed with about their volume") {
  for (double width = 0.3; width <= 1.65; width += 0.05) {
    auto s = bare_settings();
    s.slice.infill_density = 1;
    CAPTURE(width);
    const auto plan = toolpath::build(box_stack(30, width, 1), s);
    const double part = 30 * width * 1;
    double printed = 0;
    for (const auto& path : plan.layers[2].paths) printed += volume_mm3(path);
    printed *= static_cast<double>(plan.layers.size());
    // A wall's sides are as round as its outer beads'.
    CHECK(printed > 0.89 * 30 * toolpath::bead_spacing_mm(width, plan.layers[2].span.height_mm()));
    CHECK(printed < 1.12 * part);
    // Closed: what the beads leave bare is nowhere a tenth of a millimetre wide.
    const geom::Regions own{rectangle(50, 50, 80, 50 + width)};
    const geom::Regions bare =
        geom::subtract(own, covered(
                                plan.layers[2], [](const auto&) { return true; }, 0.05));
    CHECK(geom::to_mm2(geom::area(geom::open(bare, from_mm(0.05)))) < 0.02 * 30 * width);
  }
}

TEST_CASE("what is thinner than any line is printed all the same") {
  auto s = bare_settings();
  for (const double width : {0.05, 0.1, 0.2}) {
    double length = 0;
    const auto plan = toolpath::build(box_stack(30, width, 1), s);
    for (const auto& path : plan.layers[2].paths) length += geom::length(path.points) / geom::kNmPerMm;
    CAPTURE(width);
    CHECK(length > 29);
    CHECK(length < 31);
  }
  const auto pillar = toolpath::build(box_stack(0.25, 0.25, 1), s).layers[2];
  REQUIRE(pillar.paths.size() == 1);
  CHECK(geom::length(pillar.paths[0].points) > 0.05 * geom::kNmPerMm);
  CHECK(geom::bounds(pillar.paths[0].points)->min.x >= from_mm(50));
  CHECK(geom::bounds(pillar.paths[0].points)->max.x <= from_mm(50.25));
}

TEST_CASE("a short wide gap's line keeps its round ends inside") {
  auto s = bare_settings();
  s.slice.perimeters = 1;
  std::size_t seen = 0;
  for (double x = 0.5; x < 2.5; x += 0.11)
    for (const double y : {0.5, 0.7, 0.8, 1.2, 1.6}) {
      const auto plan = toolpath::build(box_stack(x, y, 1), s);
      for (const auto& path : plan.layers[2].paths) {
        if (path.role != toolpath::Role::gap_fill) continue;
        for (const geom::Point& p : {path.points.front(), path.points.back()}) {
          const double px = geom::to_mm(p.x) - 50, py = geom::to_mm(p.y) - 50;
          CAPTURE(x, y, px, py, path.width_mm);
          CHECK(std::min({px, py, x - px, y - py}) >= 0.5 * path.width_mm - 0.05);
          ++seen;
        }
      }
    }
  CHECK(seen > 50);
}

TEST_CASE("a wide gap's line keeps inside the outline all along") {
  const toolpath::BeadSize bead;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(0.2, 0.9);
  double within = 0, without = 0;  // mm outside
  for (int k = 0; k < 150; ++k) {
    geom::Region gap;
    for (int corner = 0; corner < 7; ++corner) {
      const double a = 2 * std::numbers::pi * corner / 7, r = radius(random);
      gap.outer.push_back({from_mm(r * std::cos(a)), from_mm(r * std::sin(a))});
    }
    const toolpath::Border border({gap});
    const auto outside = [&](const geom::Region* outline) {
      std::vector<toolpath::Path> lines;
      toolpath::add_gap_lines(lines, {gap}, bead, 0.0125, outline, 1);
      double most = 0;
      for (const auto& line : lines)
        for (const auto& p : line.points)
          most = std::max(most, 0.5 * line.width_mm - border.distance_mm(p, 1));
      return most;
    };
    within = std::max(within, outside(&gap));
    without = std::max(without, outside(nullptr));
  }
  CHECK(within < 0.11);
  CHECK(without > 0.15);  // chords alone tell too much
}

TEST_CASE("walls that narrow to nothing keep their beads inside") {
  auto s = bare_settings();
  const auto stack = stack_of(1, 0.2, [](double) {
    return geom::Regions{
        {{{from_mm(50), from_mm(50)}, {from_mm(80), from_mm(50)}, {from_mm(50), from_mm(52.5)}}, {}}};
  });
  const auto plan = toolpath::build(stack, s);
  const geom::Regions allowed = geom::offset(stack[2].regions, from_mm(0.08));
  for (const auto& path : plan.layers[2].paths) {
    const auto over = geom::clip_outside({line_of(path)}, allowed);
    CHECK(over.empty());
  }
  const geom::Regions bare =
      geom::subtract(stack[2].regions, covered(
                                           plan.layers[2], [](const auto&) { return true; }, 0.05));
  CHECK(geom::to_mm2(geom::area(geom::open(bare, from_mm(0.1)))) <
        0.1 * geom::to_mm2(geom::area(stack[2].regions)));
}

TEST_CASE("an area too small for a wall gets a spot that fills it and stays inside") {
  auto s = bare_settings();
  for (const int sides : {3, 4, 5, 6, 9})
    for (const double radius : {0.2, 0.25, 0.3, 0.35, 0.4}) {
      CAPTURE(sides, radius);
      const auto stack = stack_of(1, 0.2, [&](double) {
        return geom::Regions{{geom::make_circle({from_mm(50), from_mm(50)}, from_mm(radius), sides), {}}};
      });
      const auto layer = toolpath::build(stack, s).layers[2];
      REQUIRE(!layer.paths.empty());
      const double inscribed = radius * std::cos(3.14159265358979 / sides);
      for (const auto& path : layer.paths) {
        if (path.closed || inscribed < 0.1) continue;  // what is thinner than any bead is left as wide as one
        const double reach = 0.5 * path.width_mm;
        for (const geom::Point& p : path.points)
          CHECK(geom::distance(p, {from_mm(50), from_mm(50)}) / geom::kNmPerMm + reach < radius + 0.08);
      }
      double printed = 0;  // round ends included
      for (const auto& path : layer.paths)
        printed += length_mm(path) * path.width_mm +
                   (path.closed ? 0 : 3.14159265358979 / 4 * path.width_mm * path.width_mm);
      CHECK(printed > 0.45 * geom::to_mm2(geom::area(stack[2].regions)));
    }
}

TEST_CASE("the spot for what is smaller than a spot reaches hardly beyond it") {
  const auto plan = toolpath::build(box_stack(0.08, 0.06, 1), bare_settings());
  REQUIRE(plan.layers[2].paths.size() == 1);
  const toolpath::Path& spot = plan.layers[2].paths[0];
  const auto box = geom::bounds(spot.points);
  const double beyond = 0.5 * spot.width_mm;
  CHECK(geom::to_mm(box->min.x) - beyond > 50 - 0.08);
  CHECK(geom::to_mm(box->max.x) + beyond < 50.08 + 0.08);
  CHECK(length_mm(spot) > 0.04);
}

TEST_CASE("a hollow that walls leave in their middle is closed") {
  auto s = bare_settings();
  // Two walls leave a hollow of 0.1 to 0.8 mm.
  std::size_t hollows = 0;
  for (double radius = 0.9; radius < 1.25; radius += 0.03) {
    CAPTURE(radius);
    const auto stack = stack_of(1, 0.2, [&](double) {
      return geom::Regions{{geom::make_circle({from_mm(50), from_mm(50)}, from_mm(radius), 48), {}}};
    });
    const auto layer = toolpath::build(stack, s).layers[4];
    const auto walls = covered(layer, [](const auto& p) { return p.closed; });
    const auto all = covered(
        layer, [](const auto&) { return true; }, 0.02);
    const auto holes = [&](const geom::Regions& beads) {
      return geom::open(geom::subtract(stack[4].regions, beads), from_mm(0.15));
    };
    hollows += holes(walls).empty() ? 0u : 1u;
    CHECK(holes(all).empty());
  }
  CHECK(hollows > 3);
}

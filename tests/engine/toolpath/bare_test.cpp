#include "engine/toolpath/overhang/bare.h"

#include "engine/toolpath/walls/gap_lines.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;

namespace {

double area_mm2(const geom::Regions& r) { return geom::area(r) / (geom::kNmPerMm * geom::kNmPerMm); }

struct Printed {
  toolpath::LayerWalls walls;
  std::vector<toolpath::Path> gap_lines;
  geom::Regions bare;
};

Printed printed(const geom::Regions& outline) {
  slice::Layer layer;
  layer.span = {1.0, 1.2};
  layer.regions = outline;
  const toolpath::SliceSettings s;
  Printed out;
  out.walls = toolpath::draft_walls(layer, 5, s);
  for (const auto& island : out.walls.islands) {
    toolpath::add_gap_lines(out.gap_lines, island.gaps, out.walls.bead, s.resolution_mm);
    toolpath::add_thin_lines(out.gap_lines, island.thin, out.walls.bead, s.resolution_mm);
  }
  out.bare = toolpath::bare_parts(out.walls, out.gap_lines, outline);
  return out;
}

/// What begins left of an x, mm.
geom::Regions left_of(const geom::Regions& regions, double x_mm) {
  geom::Regions out;
  for (const geom::Region& r : regions)
    if (geom::bounds(r.outer)->min.x < from_mm(x_mm)) out.push_back(r);
  return out;
}

}  // namespace

TEST_CASE("what walls and gap lines cover is not bare, but for corners beside round ends") {
  CHECK(printed({rectangle(50, 50, 70, 70)}).bare.empty());
  CHECK(area_mm2(printed({rectangle(50, 50, 70, 50.6)}).bare) < 0.2);
  CHECK(area_mm2(printed(geom::unite({rectangle(50, 50, 70, 70)}, {rectangle(70, 60, 76, 60.3)})).bare) <
        0.1);
}

TEST_CASE("without its lines a web is bare, and only the web") {
  Printed web = printed(geom::unite({rectangle(50, 50, 60, 70)}, {rectangle(60, 60, 66, 60.3)}));
  REQUIRE(!web.gap_lines.empty());
  const geom::Regions bare = toolpath::bare_parts(web.walls, {}, {});
  CHECK(area_mm2(bare) == Approx(6 * 0.3).epsilon(0.1));
}

TEST_CASE("a bump too short for a line of its own is bare") {
  const Printed bump = printed(geom::unite({rectangle(50, 50, 70, 70)}, {rectangle(70, 60, 70.35, 60.24)}));
  CHECK(bump.gap_lines.empty());
  const auto box = geom::bounds(bump.bare);
  REQUIRE(box.has_value());
  CHECK(geom::to_mm(box->min.x) > 69.9);
  CHECK(geom::to_mm(box->max.x) == Approx(70.35).margin(0.02));
}

TEST_CASE("the tip of an acute corner is bare as far as a round bead stays away from it") {
  for (const double half_deg : {15.0, 25.0, 35.0, 45.0}) {
    CAPTURE(half_deg);
    const double half = half_deg * M_PI / 180;
    const geom::Region wedge{{{from_mm(50), from_mm(50)},
                              {from_mm(70), from_mm(50 - 20 * std::tan(half))},
                              {from_mm(70), from_mm(50 + 20 * std::tan(half))}},
                             {}};
    const Printed p = printed({wedge});
    const auto box = geom::bounds(geom::open(left_of(p.bare, 52), from_mm(0.02)));
    const double reach = 0.5 * p.walls.bead.width_mm * (1 / std::sin(half) - 1);
    REQUIRE(box.has_value() == (half_deg < 40));
    if (!box) continue;
    CHECK(geom::to_mm(box->max.x) - 50 > 0.75 * reach);
    // In a blade no wall has room, and more is bare.
    CHECK(geom::to_mm(box->max.x) - 50 < reach + (half_deg < 20 ? 0.6 : 0.02));
  }
}

TEST_CASE("without walls, what only lines in the margin of fill cover is bare when they are left out") {
  toolpath::PrintSettings s = bare_settings();
  s.slice.perimeters = 0;
  double margins_mm = 0;
  // Lines that run nearly along the border step away from it.
  for (double slant = 0.2; slant < 1; slant += 0.1) {
    slice::Layer layer;
    layer.span = {1.0, 1.2};
    layer.regions = {{{{from_mm(50), from_mm(50)},
                       {from_mm(60), from_mm(50)},
                       {from_mm(60), from_mm(53 + slant)},
                       {from_mm(50), from_mm(53)}},
                      {}}};
    auto walls = toolpath::draft_walls(layer, 5, s.slice);
    toolpath::Surfaces surfaces;
    surfaces.solid = toolpath::inner_of(walls);
    const auto draft = toolpath::draft_layer(layer, 5, walls, surfaces, {}, {}, {}, s);
    geom::Polylines margins;
    for (const auto& path : draft.islands.at(0).fills)
      if (path.role == toolpath::Role::gap_fill) margins.push_back(path.points);
    CAPTURE(slant);
    const auto bare = toolpath::bare_parts(walls, {}, layer.regions);
    for (const auto& line : margins) margins_mm += geom::length(line) / geom::kNmPerMm;
    CHECK(geom::clip_outside(margins, geom::offset(bare, from_mm(0.01))).empty());
    CHECK(area_mm2(toolpath::bare_parts(walls, draft.islands.at(0).fills, layer.regions)) < 0.2);
  }
  CHECK(margins_mm > 15);
}

#include "engine/toolpath/adhesion/adhesion.h"

#include "engine/toolpath/adhesion/brim.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

TEST_CASE("the skirt goes around everything at its distance") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 3;
  s.slice.skirt_layers = 2;
  const auto stack = arch_stack(40, 15, 3, 1, 6);
  const auto plan = toolpath::build(stack, s);
  for (std::size_t i = 0; i < 3; ++i) CHECK(count(plan.layers[i], Role::skirt_brim) == (i < 2 ? 3u : 0u));
  const auto near = geom::offset(stack[0].regions, from_mm(s.slice.skirt_gap_mm - 0.01), geom::Join::round);
  for (const auto& p : plan.layers[0].paths) {
    if (p.role != Role::skirt_brim) continue;
    CHECK(p.closed);
    CHECK(geom::clip_inside({line_of(p)}, near).empty());
    for (const auto& other : plan.layers[0].paths)
      if (other.role != Role::skirt_brim) CHECK(geom::contains(p.points, other.points.front()));
  }
}

TEST_CASE("the brim lies outside, wall to wall, and in no hole") {
  toolpath::PrintSettings s = bare_settings();
  s.slice.brim_width_mm = 4;
  const auto stack = stack_of(1, 0.2, [](double) {
    geom::Region r = rectangle(50, 50, 80, 80);
    geom::Ring hole = rectangle(60, 60, 70, 70).outer;
    geom::reverse(hole);
    r.holes.push_back(hole);
    return geom::Regions{r};
  });
  const auto plan = toolpath::build(stack, s);
  const auto brim = covered(
      plan.layers[0], [](const auto& p) { return p.role == Role::skirt_brim; }, 0.02);
  const geom::Regions filled{rectangle(50, 50, 80, 80)};
  CHECK(geom::to_mm2(geom::area(geom::intersect(brim, geom::offset(filled, -from_mm(0.06))))) < 1e-3);
  const auto band = geom::subtract(geom::offset(filled, from_mm(3.6), geom::Join::round), filled);
  CHECK(geom::to_mm2(geom::area(geom::subtract(band, brim))) < 0.02 * geom::to_mm2(geom::area(band)));
  CHECK(count(plan.layers[1], Role::skirt_brim) == 0);
}

TEST_CASE("the brim lies where its type says") {
  geom::Region plate = rectangle(50, 50, 90, 90);
  geom::Ring hole = rectangle(60, 60, 80, 80).outer;
  geom::reverse(hole);
  plate.holes.push_back(hole);
  const geom::Regions part{plate};
  const geom::Regions filled{rectangle(50, 50, 90, 90)};
  toolpath::SliceSettings s;
  s.brim_width_mm = 4;
  s.brim_gap_mm = 0.1;
  const toolpath::BeadSize bead{0.45, 0.2};
  auto loops = [&](toolpath::BrimType type) {
    s.brim_type = type;
    return toolpath::make_brim(part, part, s, bead).loops;
  };
  auto inside = [&](const geom::Rings& rings) {
    return std::count_if(rings.begin(), rings.end(),
                         [&](const geom::Ring& r) { return geom::contains(filled[0], r.front()); });
  };
  const auto outer = loops(toolpath::BrimType::outer);
  const auto inner = loops(toolpath::BrimType::inner);
  const auto both = loops(toolpath::BrimType::both);
  CHECK(outer.size() == 9);  // 4 mm / 0.407 mm
  CHECK(inside(outer) == 0);
  CHECK(inner.size() == 9);
  CHECK(inside(inner) == 9);
  CHECK(both.size() == 18);
  for (const auto& ring : both) {
    const geom::Polyline line = [&] {
      geom::Polyline l = ring;
      l.push_back(ring.front());
      return l;
    }();
    CHECK(geom::clip_inside({line}, geom::offset(part, from_mm(0.1 + 0.18), geom::Join::round)).empty());
  }
}

TEST_CASE("ears sit at sharp convex corners alone") {
  // A hexagon has inner angles of 120°, an octagon of 135°; an L has five convex corners.
  auto polygon = [](int sides) {
    return geom::Regions{{geom::make_circle({from_mm(80), from_mm(80)}, from_mm(20), sides), {}}};
  };
  CHECK(toolpath::sharp_corners(polygon(6), 125).size() == 6);
  CHECK(toolpath::sharp_corners(polygon(8), 125).empty());
  CHECK(toolpath::sharp_corners(polygon(8), 140).size() == 8);
  CHECK(toolpath::sharp_corners(polygon(128), 140).empty());
  const auto el = geom::unite({rectangle(0, 0, 40, 10)}, {rectangle(0, 0, 10, 40)});
  CHECK(toolpath::sharp_corners(el, 125).size() == 5);

  toolpath::PrintSettings s = bare_settings();
  s.slice.brim_type = toolpath::BrimType::ears;
  s.slice.brim_width_mm = 5;
  const auto stack = stack_of(1, 0.2, [](double) { return geom::Regions{rectangle(50, 50, 90, 90)}; });
  const auto plan = toolpath::build(stack, s);
  CHECK(count(plan.layers[0], Role::skirt_brim) == 4);  // each in one go
  const auto ears = covered(
      plan.layers[0], [](const auto& p) { return p.role == Role::skirt_brim; }, 0.02);
  geom::Rings discs;
  for (const double x : {50.0, 90.0})
    for (const double y : {50.0, 90.0})
      discs.push_back(geom::make_circle({from_mm(x), from_mm(y)}, from_mm(5)));
  const auto wanted = geom::subtract(geom::unite(discs), stack[0].regions);
  CHECK(geom::area(geom::subtract(wanted, ears)) < 0.1 * geom::area(wanted));
  CHECK(geom::area(geom::subtract(ears, geom::offset(wanted, from_mm(0.3)))) < 0.01 * geom::area(wanted));
}

TEST_CASE("a tall skirt stays clear of what leans out above the plate") {
  toolpath::PrintSettings s = bare_settings();
  s.slice.skirt_loops = 1;
  s.slice.skirt_layers = 30;
  const auto stack = cone_stack(5, 6, 12);
  const auto plan = toolpath::build(stack, s);
  for (std::size_t i = 0; i < 30; ++i) {
    REQUIRE(count(plan.layers[i], Role::skirt_brim) == 1);
    for (const auto& p : plan.layers[i].paths)
      if (p.role == Role::skirt_brim)
        CHECK(geom::clip_inside({line_of(p)}, geom::offset(stack[i].regions, from_mm(2.9), geom::Join::round))
                  .empty());
  }
}

TEST_CASE("the first layer's flow is its own") {
  toolpath::PrintSettings s = bare_settings();
  const auto plain = toolpath::build(box_stack(20, 20, 1), s);
  s.filament.first_layer_flow = 1.1;
  const auto more = toolpath::build(box_stack(20, 20, 1), s);
  for (std::size_t i = 0; i < plain.layers.size(); ++i)
    for (std::size_t k = 0; k < plain.layers[i].paths.size(); ++k)
      CHECK(more.layers[i].paths[k].area_mm2 ==
            Approx(plain.layers[i].paths[k].area_mm2 * (i == 0 ? 1.1 : 1.0)));
}

TEST_CASE("the elephant's foot is taken off the first layer alone") {
  toolpath::PrintSettings s = bare_settings();
  s.slice.elephant_foot_mm = 0.2;
  const auto plan = toolpath::build(box_stack(20, 20, 1), s);
  auto left = [](const toolpath::LayerPlan& layer) {
    double x = 1e9;
    for (const auto& p : layer.paths)
      for (const auto& q : p.points) x = std::min(x, geom::to_mm(q.x));
    return x;
  };
  CHECK(left(plan.layers[0]) - left(plan.layers[1]) == Approx(0.2).margin(0.005));
}

TEST_CASE("a convex hull holds all points and has only left turns") {
  std::vector<geom::Point> points;
  std::uint64_t seed = 7;
  auto next = [&] {
    return static_cast<geom::Coord>((seed = seed * 6364136223846793005ULL + 1442695040888963407ULL) >> 36);
  };
  for (int i = 0; i < 300; ++i) points.push_back({next(), next()});
  const auto hull = toolpath::convex_hull(points);
  CHECK(geom::area(hull) > 0);
  for (const auto& p : points) CHECK(geom::contains(hull, p));
}

TEST_CASE("place_on_bed moves to the middle of the bed") {
  toolpath::MachineShape m;
  m.bed_mm = {200, 100};
  slice::LayerStack stack = stack_of(0.4, 0.2, [](double) { return geom::Regions{rectangle(-5, -5, 5, 5)}; });
  auto centred = stack;
  toolpath::place_on_bed(stack, m);
  CHECK(geom::bounds(stack[0].regions)->min == geom::Point{from_mm(95), from_mm(45)});
  m.origin_at_centre = true;
  toolpath::place_on_bed(centred, m);
  CHECK(geom::bounds(centred[1].regions)->min == geom::Point{from_mm(-5), from_mm(-5)});
}

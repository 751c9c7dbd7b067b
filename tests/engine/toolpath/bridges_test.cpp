#include "engine/geom/area_grid.h"
#include "engine/toolpath/fill/bridge_lines.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/overhang/overhangs.h"
#include "engine/toolpath/overhang/unheld.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using geom::Point;
using std::numbers::pi;
using toolpath::Role;

namespace {

geom::Region polygon(std::initializer_list<std::pair<double, double>> corners) {
  geom::Region out;
  for (const auto& [x, y] : corners) out.outer.push_back({from_mm(x), from_mm(y)});
  return out;
}

bool in(const geom::Regions& areas, const Point& p) {
  return std::any_of(areas.begin(), areas.end(), [&](const auto& r) { return geom::contains(r, p); });
}

/// A plate over a gear: what is between its teeth hangs, and a tooth holds the bridges on both sides of it.
slice::LayerStack over_a_gear(int teeth, double root, double tip, double plate) {
  return stack_of(2.4, 0.2, [=](double z) {
    geom::Region r;
    for (int k = 0; k < 2 * teeth; ++k) {
      const double radius = z > 1.6 ? plate : k % 2 == 0 ? tip : root;
      const double a = pi * k / teeth;
      r.outer.push_back({from_mm(80 + radius * std::cos(a)), from_mm(80 + radius * std::sin(a))});
    }
    return geom::Regions{r};
  });
}

}  // namespace

TEST_CASE("a bridge's strands end on ground, or go on, wherever ground can be reached") {
  const geom::Region wedge = polygon({{50, 50}, {62, 50}, {56, 57}});
  const geom::Region leaning = polygon({{50, 50}, {60, 50}, {64, 58}, {54, 58}});
  struct Case {
    geom::Region domain;
    geom::Regions ground;
  };
  std::size_t seen = 0, in_air = 0;
  for (const Case& c : {Case{wedge, {rectangle(48, 48, 64, 51), rectangle(54, 54.5, 58, 60)}},
                        Case{wedge, {rectangle(48, 48, 54, 60), rectangle(58, 48, 64, 60)}},
                        Case{leaning, {rectangle(48, 48, 66, 51), rectangle(48, 55, 66, 60)}},
                        Case{leaning, {rectangle(48, 48, 66, 50.5), rectangle(48, 57.5, 66, 60)}}})
    for (int k = 0; k < 12; ++k) {
      CAPTURE(k);
      const geom::Polylines lines = toolpath::bridge_lines(c.domain, c.ground, pi * k / 12, 0.4, {0.2, 0.2});
      REQUIRE(!lines.empty());
      const geom::Regions allowed = geom::offset({c.domain}, from_mm(0.21));
      for (const auto& line : lines) {
        for (const Point& end : {line.front(), line.back()}) {
          ++seen;
          in_air += in(c.ground, end) ? 0u : 1u;
        }
        CHECK(geom::clip_outside({line}, allowed).empty());
      }
    }
  CHECK(seen > 100);
  CHECK(in_air == 0);
}

TEST_CASE("strands go further into the walls only where ground is no nearer") {
  const geom::Region domain = polygon({{50, 50}, {60, 50}, {60, 56}, {50, 56}});
  const auto reach_mm = [&](double ground_x) {
    const geom::Regions ground{rectangle(45, 45, ground_x, 60), rectangle(59, 45, 65, 60)};
    double left = 1e9;
    for (const auto& line : toolpath::bridge_lines(domain, ground, 0, 0.4, {0.4, 0.7}))
      for (const Point& p : line) left = std::min(left, geom::to_mm(p.x));
    return 50 - left;
  };
  CHECK(reach_mm(50.1) <= 0.401);
  CHECK(reach_mm(49.7) <= 0.401);
  CHECK(reach_mm(49.7) >= 0.299);
  CHECK(reach_mm(49.4) >= 0.599);
  CHECK(reach_mm(49.4) <= 0.701);
  CHECK(reach_mm(49.2) <= 0.001);  // out of reach: nothing goes into the walls in vain
}

TEST_CASE("the strands of a roof that stands back on thin walls end on them") {
  const auto stack = stack_of(4, 0.2, [](double z) {
    if (z > 3) return geom::Regions{rectangle(50.1, 50.1, 59.9, 64.9)};
    geom::Region r = rectangle(50, 50, 60, 65);
    geom::Ring hollow = rectangle(50.45, 50.45, 59.55, 64.55).outer;
    geom::reverse(hollow);
    r.holes.push_back(hollow);
    return geom::Regions{r};
  });
  const auto plan = toolpath::build(stack, bare_settings());
  const geom::Regions held = geom::offset(stack[14].regions, from_mm(0.2));
  std::size_t strands = 0, in_air = 0;
  for (const auto& path : plan.layers[15].paths) {
    if (path.role != Role::bridge_infill) continue;
    ++strands;
    in_air += (in(held, path.points.front()) ? 0u : 1u) + (in(held, path.points.back()) ? 0u : 1u);
  }
  CHECK(strands > 0);
  CHECK(in_air == 0);
}

TEST_CASE("strands with no ground near are joined to others, not lost") {
  // Ground under one corner only: the far ends cannot reach it.
  const geom::Region domain = polygon({{50, 50}, {70, 50}, {70, 60}, {50, 60}});
  const geom::Regions ground{rectangle(48, 48, 51, 62)};
  const geom::Polylines lines = toolpath::bridge_lines(domain, ground, 0, 0.4, {});
  std::size_t in_air = 0;
  double length = 0;
  for (const auto& line : lines) {
    in_air += (in(ground, line.front()) ? 0u : 1u) + (in(ground, line.back()) ? 0u : 1u);
    length += geom::length(line) / geom::kNmPerMm;
  }
  CHECK(in_air <= 1);  // an odd one may be left
  CHECK(length > 10 * 20 / 0.4 * 0.9);
}

TEST_CASE("bridges on both sides of a tooth both end on it") {
  auto s = bare_settings();
  for (const int teeth : {6, 9, 12}) {
    const auto stack = over_a_gear(teeth, 6, 12, 12.5);
    const std::size_t first = 8;
    REQUIRE(stack[first].span.bottom_mm == Approx(1.6));
    const auto plan = toolpath::build(stack, s);
    const geom::Regions held = geom::offset(stack[first - 1].regions, from_mm(0.2));
    std::size_t strands = 0, in_air = 0;
    for (const auto& path : plan.layers[first].paths) {
      if (path.role != Role::bridge_infill) continue;
      ++strands;
      in_air += (in(held, path.points.front()) ? 0u : 1u) + (in(held, path.points.back()) ? 0u : 1u);
    }
    CAPTURE(teeth);
    CHECK(strands >= static_cast<std::size_t>(teeth));
    CHECK(in_air == 0);
  }
}

TEST_CASE("bridges side by side do not overlap, and neither takes all of what is between them") {
  toolpath::SliceSettings s = bare_settings().slice;
  // Two hollows 2 mm apart under a plate.
  const auto stack = stack_of(2, 0.2, [](double z) {
    geom::Region r = rectangle(50, 50, 80, 70);
    if (z > 1) return geom::Regions{r};
    for (const double x : {54.0, 66.0}) {
      geom::Ring hole = rectangle(x, 54, x + 10, 66).outer;
      geom::reverse(hole);
      r.holes.push_back(hole);
    }
    return geom::Regions{r};
  });
  std::vector<geom::Regions> inner;
  for (const auto& layer : stack) inner.push_back(geom::offset(layer.regions, -from_mm(0.9)));
  const auto found = toolpath::find_surfaces(stack, inner, s, {})[5].bridges;
  REQUIRE(found.size() == 2);
  CHECK(geom::area(geom::intersect(found[0].area, found[1].area)) == 0);
  for (const auto& bridge : found) {
    const auto box = geom::bounds(bridge.area);
    REQUIRE(box);
    // Half of the 2 mm between, with what rounding takes.
    CHECK(geom::to_mm(box->max.x - box->min.x) > 10 + 1.2 + 0.7);
    CHECK(in(bridge.ground, {from_mm(52), from_mm(60)}) != in(bridge.ground, {from_mm(78), from_mm(60)}));
    CHECK(in(bridge.ground, {from_mm(65), from_mm(60)}));
    CHECK(!in(bridge.ground, {from_mm(59), from_mm(60)}));
  }
}

TEST_CASE("what hangs without hold and found no support is a bridge after all") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  s.slice.support = toolpath::SupportMode::plate;
  // A shelf over the part's own foot: no support from the plate gets there.
  const auto stack = stack_of(8, 0.2, [](double z) {
    if (z < 1 || z > 6) return geom::Regions{rectangle(50, 50, 80, 80)};
    return geom::Regions{rectangle(50, 50, 60, 80)};
  });
  const auto bridged = [&] {
    const auto plan = toolpath::build(stack, s);
    double sum = 0;
    for (const auto& path : plan.layers[30].paths)
      if (path.role == Role::bridge_infill) sum += length_mm(path);
    return sum;
  };
  const double area = 20 * 30;
  CHECK(bridged() > 0.7 * area / s.machine.nozzle_mm);
  s.slice.support = toolpath::SupportMode::everywhere;
  CHECK(bridged() < 0.2 * area / s.machine.nozzle_mm);
}

TEST_CASE("a loop whose seam hangs begins where it is held") {
  const toolpath::SpeedSettings speed = bare_settings().speed;
  const geom::Regions below{rectangle(50, 50, 60, 70)}, own{rectangle(50, 50, 70, 70)};
  toolpath::Path loop;
  loop.role = Role::external_perimeter;
  loop.width_mm = 0.45;
  loop.area_mm2 = 0.08;
  loop.closed = true;
  const double a = 50.225, b = 69.775;
  const std::vector<Point> corners{
      {from_mm(b), from_mm(b)}, {from_mm(a), from_mm(b)}, {from_mm(a), from_mm(a)}, {from_mm(b), from_mm(a)}};
  for (std::size_t seam = 0; seam < 4; ++seam) {
    loop.points = corners;
    std::rotate(loop.points.begin(), loop.points.begin() + static_cast<std::ptrdiff_t>(seam),
                loop.points.end());
    std::vector<toolpath::Path> paths{loop};
    toolpath::mark_overhangs(paths, own, below, {}, 0.45, speed);
    CAPTURE(seam);
    REQUIRE(paths.size() >= 2);
    CHECK(paths.front().role == Role::external_perimeter);
    double length = 0;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      length += length_mm(paths[i]);
      CHECK(paths[i].points.back() == paths[(i + 1) % paths.size()].points.front());
    }
    CHECK(length == Approx(4 * (b - a)));
  }
}

TEST_CASE("a bridge on rails no wider than its outer wall ends on them") {
  auto s = bare_settings();
  const auto stack = stack_of(2, 0.2, [](double z) {
    if (z > 1) return geom::Regions{rectangle(50, 50, 54, 56)};
    return geom::Regions{rectangle(50, 50, 50.5, 56), rectangle(53.5, 50, 54, 56)};
  });
  const auto plan = toolpath::build(stack, s);
  std::size_t seen = 0;
  for (const auto& path : plan.layers[5].paths) {
    if (path.role != Role::bridge_infill) continue;
    for (const Point& end : {path.points.front(), path.points.back()}) {
      ++seen;
      const double x = geom::to_mm(end.x) - 50;
      CHECK(std::min(x, 4 - x) < 0.5 + 0.2);
      CHECK(std::min(x, 4 - x) > 0.2);  // inside
    }
  }
  CHECK(seen >= 2);
}

TEST_CASE("what no support beside it holds is bridged after all") {
  const auto stack =
      stack_of(0.8, 0.2, [](double z) { return geom::Regions{rectangle(50, 50, z > 0.6 ? 64 : 60, 60)}; });
  const auto bridged_mm2 = [&](double support_from_x) {
    std::vector<toolpath::Surfaces> surfaces(stack.size());
    surfaces[3].solid = {rectangle(51, 51, 63, 59)};
    surfaces[3].unheld = {rectangle(60, 51, 63, 59)};
    std::vector<toolpath::SupportAreas> supports(stack.size());
    supports[1].interface = {rectangle(support_from_x, 51, 66, 59)};  // the gap below
    toolpath::bridge_unheld(surfaces, stack, supports, bare_settings().slice, {});
    double sum = 0;
    for (const auto& b : surfaces[3].bridges) sum += geom::to_mm2(geom::area(b.hanging));
    return sum;
  };
  CHECK(bridged_mm2(60.5) == 0);
  CHECK(bridged_mm2(61.5) == Approx(8).margin(0.1));
  CHECK(bridged_mm2(70) == Approx(24).margin(0.1));
}

TEST_CASE("without walls, bridges end on what is printed below, not in the margin the lines there leave") {
  auto s = bare_settings();
  s.slice.perimeters = 0;
  s.slice.infill_density = 1;
  for (int turn = 0; turn < 24; ++turn) {
    // A ring over a block with a three-cornered hole.
    geom::Ring hole;
    for (int k = 0; k < 3; ++k) {
      const double angle = turn * pi / 36 + 2 * k * pi / 3;
      hole.push_back({from_mm(58 + 4 * std::cos(angle)), from_mm(57 + 4 * std::sin(angle))});
    }
    const geom::Regions block{rectangle(50, 50, 66, 66)};
    const geom::Regions ring =
        geom::subtract(geom::Regions{{geom::make_circle({from_mm(58), from_mm(58)}, from_mm(4), 12), {}}},
                       {{geom::make_circle({from_mm(58), from_mm(58)}, from_mm(2.6), 12), {}}});
    const auto stack = stack_of(1.4, 0.2, [&](double z) {
      return z < 1 ? geom::subtract(block, geom::Regions{{hole, {}}}) : ring;
    });
    const auto plan = toolpath::build(stack, s);
    const auto below = covered(plan.layers[4], [](const toolpath::Path&) { return true; });
    const geom::AreaGrid ground(geom::offset(below, from_mm(0.12)));
    CAPTURE(turn);
    for (const auto& path : plan.layers[5].paths)
      if (path.role == Role::bridge_infill && !path.closed)
        for (const auto& end : {path.points.front(), path.points.back()}) CHECK(ground.contains(end));
  }
}

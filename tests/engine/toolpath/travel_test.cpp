#include "engine/toolpath/travel/travel.h"

#include "engine/geom/area_grid.h"
#include "tests/engine/toolpath/shapes.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

geom::Point at(double x, double y) { return {from_mm(x), from_mm(y)}; }

/// A plate with a square hole in its middle.
geom::Region frame(double size, double hole) {
  geom::Region r = rectangle(0, 0, size, size);
  const double a = 0.5 * (size - hole), b = 0.5 * (size + hole);
  r.holes.push_back(rectangle(a, a, b, b).outer);
  geom::reverse(r.holes.back());
  return r;
}

/// The way from `from` to a short path that begins at `to`.
toolpath::Travel way(const geom::Regions& outline, const geom::Point& from, const geom::Point& to,
                     const geom::Regions& support = {}, Role role = Role::infill) {
  toolpath::LayerPlan layer;
  layer.span = {0, 0.2};
  layer.outline = outline;
  layer.support = support;
  toolpath::Path first, second;
  first.role = second.role = role;
  first.points = {{from.x + from_mm(0.2), from.y}, from};
  second.points = {to, {to.x + from_mm(0.2), to.y}};
  layer.paths = {first, second};
  return toolpath::plan_travels(layer, std::nullopt, {})[1];
}

geom::Polyline whole(const geom::Point& from, const toolpath::Travel& travel, const geom::Point& to) {
  geom::Polyline line{from};
  line.insert(line.end(), travel.via.begin(), travel.via.end());
  line.push_back(to);
  return line;
}

}  // namespace

TEST_CASE("a way goes round a hole while that is short, and is retracted otherwise") {
  const geom::Regions small{frame(30, 6)};
  const auto round = way(small, at(10, 15.5), at(20, 15.5));
  CHECK_FALSE(round.retract);
  REQUIRE(round.via.size() >= 2);
  const geom::Polyline line = whole(at(10, 15.5), round, at(20, 15.5));
  CHECK(geom::clip_outside({line}, small).empty());
  // By the hole's upper corners, 0.12 mm off: 2 x hypot(1.88, 2.62) + 6.24.
  CHECK(geom::length(line) < 12.7 * geom::kNmPerMm);

  const auto straight = way(small, at(2, 2), at(28, 2));
  CHECK_FALSE(straight.retract);
  CHECK(straight.via.empty());

  const auto far = way({frame(100, 80)}, at(5, 50), at(95, 50));
  CHECK(far.retract);
  CHECK(far.via.empty());
}

TEST_CASE("ways stay on the part whatever its outline, or are retracted") {
  // A comb: teeth along y on a back along x.
  geom::Ring ring{at(0, 0), at(44, 0)};
  for (int tooth = 5; tooth-- > 0;) {
    const double x = 8.0 * tooth;
    for (const auto& p : {at(x + 4, 3), at(x + 4, 9), at(x, 9), at(x, 3)}) ring.push_back(p);
  }
  ring[1] = at(36, 0);
  const geom::Regions comb{{ring, {}}};
  const geom::AreaGrid grid(comb);
  std::size_t detours = 0, retracted = 0;
  for (int a = 0; a < 5; ++a)
    for (int b = 0; b < 5; ++b) {
      const geom::Point from = at(8 * a + 1, 8.5), to = at(8 * b + 2.5, 8);
      const auto travel = way(comb, from, to);
      if (travel.retract) ++retracted;
      if (travel.retract) continue;
      if (!travel.via.empty()) ++detours;
      if (geom::distance(from, to) > 1.5 * geom::kNmPerMm)
        CHECK(geom::clip_outside({whole(from, travel, to)}, comb).empty());
    }
  CHECK(detours >= 4);
  CHECK(detours + retracted == 20);
}

TEST_CASE("between supports nothing is retracted, but over the part and far across the open") {
  const geom::Regions part{rectangle(20, 0, 30, 10)};
  const geom::Regions near{rectangle(0, 0, 4, 10), rectangle(8, 0, 12, 10), rectangle(40, 0, 80, 10)};
  CHECK_FALSE(way(part, at(2, 5), at(10, 5), near, Role::support).retract);
  CHECK(way(part, at(2, 5), at(10, 5), near, Role::infill).retract);
  CHECK_FALSE(way(part, at(42, 5), at(78, 5), near, Role::support).retract);
  CHECK(way(part, at(10, 5), at(42, 5), near, Role::support).retract);
  CHECK(way(part, at(10, 15), at(42, 15), near, Role::support).retract);
}

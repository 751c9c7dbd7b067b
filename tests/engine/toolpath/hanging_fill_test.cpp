#include "engine/toolpath/overhang/hanging_fill.h"

#include "tests/engine/toolpath/shapes.h"

#include <algorithm>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

toolpath::Path line(Role role, double x0, double y0, double x1, double y1) {
  toolpath::Path path;
  path.role = role;
  path.points = {{from_mm(x0), from_mm(y0)}, {from_mm(x1), from_mm(y1)}};
  return path;
}

}  // namespace

TEST_CASE("solid lines are bridges where no printed line of support is near enough to hold them") {
  // The skin goes on from ground that ends at x = 60; a line of support lies below x = `at`.
  const geom::Regions below{rectangle(50, 50, 60, 60)};
  const geom::Regions unheld{rectangle(60, 50, 66, 60)};
  const std::vector<toolpath::Path> skin{line(Role::external_perimeter, 50, 50, 66, 50),
                                         line(Role::solid_infill, 51, 55, 65, 55)};
  const auto bridged = [&](std::vector<double> at) {
    std::vector<toolpath::Path> support;
    for (const double x : at) support.push_back(line(Role::support_interface, x, 51, x, 59));
    return toolpath::bridge_hanging_fill(skin, unheld, below, support, 0.2);
  };
  // Each line holds what is no further than half its width, 0.45 mm, and half a mm from its middle.
  CHECK_FALSE(bridged({60.5, 61.5, 62.5, 63.5, 64.5}));
  CHECK_FALSE(bridged({60.9, 62.3, 63.7, 64.9}));  // no further than the lean from ground, and a dot
  const auto paths = bridged({60.5, 63.5, 64.5});
  REQUIRE(paths);
  REQUIRE(paths->size() == 4);
  CHECK((*paths)[0].role == Role::external_perimeter);
  CHECK((*paths)[1].role == Role::solid_infill);
  CHECK((*paths)[2].role == Role::bridge_infill);
  CHECK((*paths)[3].role == Role::solid_infill);
  // 60.5 + 0.725 to 63.5 - 0.725, as exact as the line is looked at.
  CHECK(geom::to_mm((*paths)[2].points.front().x) == Approx(61.225).margin(0.1));
  CHECK(geom::to_mm((*paths)[2].points.back().x) == Approx(62.775).margin(0.1));
  for (std::size_t k = 2; k < 4; ++k) CHECK((*paths)[k].points.front() == (*paths)[k - 1].points.back());
  CHECK((*paths)[3].points.back() == skin[1].points.back());

  const auto all = bridged({});
  REQUIRE(all);
  CHECK(geom::to_mm(all->back().points.front().x) == Approx(60.2).margin(0.1));
  CHECK_FALSE(toolpath::bridge_hanging_fill(skin, {}, below, {}, 0.2));
}

TEST_CASE("where support's last line lies short of its corner, the skin above it is a bridge") {
  // A plate over a wedge, beside whose edge the column's own becomes too narrow for another of its lines.
  const auto stack = stack_of(8, 0.2, [](double z) {
    geom::Regions out{
        {{{from_mm(80), from_mm(80)}, {from_mm(90), from_mm(72)}, {from_mm(90), from_mm(88)}}, {}}};
    return z > 7 ? geom::Regions{rectangle(70, 70, 92, 90)} : out;
  });
  const toolpath::PrintSettings s;
  const toolpath::Plan plan = toolpath::build(stack, s);
  const auto first = static_cast<std::size_t>(7 / 0.2 + 0.5);
  const auto is_support = [](const toolpath::Path& p) {
    return p.role == Role::support || p.role == Role::support_interface;
  };
  // Support's top lies the gap below.
  const geom::Regions support = covered(plan.layers[first - 2], is_support, 0.5);
  REQUIRE(!support.empty());
  const geom::Regions held = geom::unite(support, geom::offset(stack[first - 1].regions, from_mm(0.2)));
  std::size_t skins = 0;
  for (const auto& path : plan.layers[first].paths) {
    if (path.role != Role::solid_infill && path.role != Role::top_solid_infill) continue;
    ++skins;
    for (const auto& piece : geom::clip_outside({line_of(path)}, held))
      CHECK(geom::length(piece) / geom::kNmPerMm < 0.5);
  }
  CHECK(skins > 0);
}

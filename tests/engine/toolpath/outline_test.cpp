#include "engine/toolpath/outline.h"

#include "tests/engine/toolpath/shapes.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;

namespace {

double area_mm2(const geom::Regions& r) { return geom::to_mm2(geom::area(r)); }

/// A 20 mm plate with a 10 mm hole and an island of 4 mm in it.
geom::Regions nested() {
  geom::Region plate = rectangle(0, 0, 20, 20);
  geom::Ring hole = rectangle(5, 5, 15, 15).outer;
  geom::reverse(hole);
  plate.holes.push_back(hole);
  return {plate, rectangle(8, 8, 12, 12)};
}

}  // namespace

TEST_CASE("contours and holes are compensated apart from one another") {
  CHECK(toolpath::compensated(nested(), 0, 0) == nested());
  auto expect = [](double outer, double hole) {
    const double side = 20 + 2 * outer;
    const double gap = 10 + 2 * hole;
    const double island = 4 + 2 * outer;
    return side * side - gap * gap + island * island;
  };
  for (const auto& [outer, hole] :
       {std::pair{0.1, 0.0}, {-0.1, 0.0}, {0.0, 0.2}, {0.0, -0.2}, {0.15, 0.1}, {-0.2, -0.1}}) {
    CAPTURE(outer, hole);
    CHECK(area_mm2(toolpath::compensated(nested(), outer, hole)) ==
          Approx(expect(outer, hole)).epsilon(1e-4));
  }
  // A hole that closes, and neighbours that meet.
  CHECK(area_mm2(toolpath::compensated({nested()[0]}, 0, -5.1)) == Approx(400));
  const geom::Regions joined =
      toolpath::compensated({rectangle(0, 0, 5, 5), rectangle(5.1, 0, 10, 5)}, 0.1, 0);
  CHECK(joined.size() == 1);
  CHECK(area_mm2(joined) == Approx(10.2 * 5.2).epsilon(1e-4));
}

TEST_CASE("the elephant's foot leaves thin features as they are") {
  const geom::Regions plate{rectangle(0, 0, 20, 20)};
  CHECK(area_mm2(toolpath::without_foot(plate, 0.2, 0.45)) == Approx(19.6 * 19.6).epsilon(1e-4));
  CHECK(toolpath::without_foot(plate, 0, 0.45) == plate);
  const geom::Regions fin{rectangle(0, 0, 20, 0.6)};  // 0.2 would be left of it
  CHECK(area_mm2(toolpath::without_foot(fin, 0.2, 0.45)) == Approx(12).epsilon(1e-3));
  const geom::Regions both = geom::unite(plate, {rectangle(20, 9, 30, 9.6)});
  const geom::Regions printed = toolpath::without_foot(both, 0.2, 0.45);
  REQUIRE(printed.size() == 1);  // the fin still holds on to the plate
  CHECK(geom::bounds(printed)->max.x == from_mm(30));
  CHECK(geom::bounds(printed)->min.x == Approx(from_mm(0.2)).margin(1000));
  CHECK(area_mm2(printed) == Approx(19.6 * 19.6 + 10 * 0.6).epsilon(0.01));
}

TEST_CASE("compensation reaches every layer, the foot only the first") {
  toolpath::SliceSettings s;
  s.xy_compensation_mm = -0.1;
  s.elephant_foot_mm = 0.15;
  const auto stack = toolpath::outlines(box_stack(20, 20, 1), s, {});
  CHECK(area_mm2(stack[0].regions) == Approx(19.5 * 19.5).epsilon(1e-4));
  for (std::size_t i = 1; i < stack.size(); ++i)
    CHECK(area_mm2(stack[i].regions) == Approx(19.8 * 19.8).epsilon(1e-4));
}

TEST_CASE("what grows keeps its right angles; sharper corners do not run ahead of its sides") {
  const double mm2 = geom::kNmPerMm * geom::kNmPerMm;
  const geom::Regions square{rectangle(0, 0, 10, 10)};
  CHECK(geom::area(toolpath::compensated(square, 0.3, 0)) / mm2 == Approx(10.6 * 10.6).epsilon(1e-3));

  // A blade of 62 degrees whose point is at (10, 0).
  const geom::Regions blade{
      {{{geom::from_mm(0), geom::from_mm(-6)}, {geom::from_mm(10), 0}, {geom::from_mm(0), geom::from_mm(6)}},
       {}}};
  const geom::Regions grown = toolpath::compensated(blade, 0.3, 0);
  const auto box = geom::bounds(grown);
  REQUIRE(box.has_value());
  CHECK(geom::to_mm(box->max.x) < 10 + 0.3 * 1.43);
  CHECK(geom::to_mm(box->max.x) > 10.29);
  CHECK(geom::area(geom::subtract(geom::offset(blade, geom::from_mm(0.29), geom::Join::round), grown)) == 0);
}

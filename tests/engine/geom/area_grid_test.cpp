#include "engine/geom/area_grid.h"

#include "engine/geom/polygon_ops.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using geom::from_mm;

TEST_CASE("the area grid agrees with plain geometry") {
  geom::Region r{geom::make_circle({}, from_mm(10), 37),
                 {geom::make_circle({from_mm(2), from_mm(1)}, from_mm(3), 11)}};
  geom::reverse(r.holes[0]);
  const geom::AreaGrid grid(geom::Regions{r});
  for (int x = -11; x <= 11; ++x)
    for (int y = -11; y <= 11; ++y) {
      const geom::Point p{from_mm(x + 0.013), from_mm(y + 0.017)};
      CHECK(grid.contains(p) == geom::contains(r, p));
    }
  CHECK(grid.contains(geom::Point{from_mm(-8), 0}, geom::Point{from_mm(-5), from_mm(5)}));
  CHECK_FALSE(grid.contains(geom::Point{from_mm(-8), from_mm(1)}, geom::Point{from_mm(8), from_mm(1)}));
  const auto pieces = grid.split({{from_mm(-12), from_mm(1)}, {from_mm(12), from_mm(1)}});
  REQUIRE(pieces.size() == 5);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    CHECK(pieces[i].inside == (i % 2 == 1));
    if (i > 0) CHECK(pieces[i].points.front() == pieces[i - 1].points.back());
  }
}

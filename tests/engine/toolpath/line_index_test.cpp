#include "engine/toolpath/line_index.h"

#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace voidpath::toolpath {

TEST_CASE("the nearest line, and whether any is near, are found as by looking at all") {
  constexpr geom::Coord kMm = 1'000'000;
  std::mt19937 random(5);
  std::uniform_int_distribution<geom::Coord> any(0, 40 * kMm), step(-6 * kMm, 6 * kMm);
  std::uniform_real_distribution<double> limit(0.05e6, 4e6);
  int near = 0, far = 0;
  for (int round = 0; round < 40; ++round) {
    LineIndex index({{0, 0}, {40 * kMm, 40 * kMm}}, round % 2 == 0 ? kMm : 3 * kMm);
    std::vector<std::pair<geom::Point, geom::Point>> lines;
    for (int k = 0; k < 5 + round; ++k) {
      const geom::Point a{any(random), any(random)}, b{a.x + step(random), a.y + step(random)};
      lines.emplace_back(a, b);
      index.add(a, b);
    }
    for (int k = 0; k < 100; ++k) {
      const geom::Point p{any(random), any(random)};
      double least = 1e300;
      for (const auto& [a, b] : lines) least = std::min(least, geom::distance(p, nearest_on_line(p, a, b)));
      const double within = limit(random);
      CHECK(index.reaches(p, within) == (least <= within));
      const LineIndex::Hit hit = index.nearest(p, within);
      if (least <= within)
        CHECK(hit.distance == least);
      else
        CHECK(hit.distance > within);
      ++(least <= within ? near : far);
    }
  }
  CHECK(near > 500);
  CHECK(far > 500);
}

}  // namespace voidpath::toolpath

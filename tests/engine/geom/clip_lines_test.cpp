#include "engine/geom/polygon_ops.h"
#include "engine/geom/svg.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace voidpath::geom {

namespace {

constexpr Coord kMm = 1'000'000;

double total_length(const Polylines& lines) {
  double sum = 0;
  for (const Polyline& l : lines) sum += length(l);
  return sum;
}

Regions square_with_hole() {
  Ring hole = make_rectangle({4 * kMm, 4 * kMm}, {6 * kMm, 6 * kMm});
  reverse(hole);
  return {{make_rectangle({0, 0}, {10 * kMm, 10 * kMm}), {hole}}};
}

}  // namespace

TEST_CASE("a line through a hole is cut in two, in its own direction") {
  const Polylines in = clip_inside({{{20 * kMm, 5 * kMm}, {-5 * kMm, 5 * kMm}}}, square_with_hole());
  REQUIRE(in.size() == 2);
  CHECK(in[0] == Polyline{{10 * kMm, 5 * kMm}, {6 * kMm, 5 * kMm}});
  CHECK(in[1] == Polyline{{4 * kMm, 5 * kMm}, {0, 5 * kMm}});
  const Polylines out = clip_outside({{{20 * kMm, 5 * kMm}, {-5 * kMm, 5 * kMm}}}, square_with_hole());
  REQUIRE(out.size() == 3);
  CHECK(out[1] == Polyline{{6 * kMm, 5 * kMm}, {4 * kMm, 5 * kMm}});
}

TEST_CASE("a polyline that stays inside comes back as it was") {
  const Polyline line{{kMm, kMm}, {9 * kMm, kMm}, {9 * kMm, 9 * kMm}, {kMm, 9 * kMm}};
  CHECK(clip_inside({line}, square_with_hole()) == Polylines{line});
  CHECK(clip_outside({line}, square_with_hole()).empty());
  CHECK(clip_inside({line}, {}).empty());
  CHECK(clip_outside({line}, {}) == Polylines{line});
}

TEST_CASE("lines through corners and along edges are cut without loss") {
  const Regions r = square_with_hole();
  // Both diagonals pass two corners of the hole and of the outline.
  for (const Polyline& diagonal :
       {Polyline{{-kMm, -kMm}, {11 * kMm, 11 * kMm}}, Polyline{{11 * kMm, -kMm}, {-kMm, 11 * kMm}}}) {
    CHECK(total_length(clip_inside({diagonal}, r)) == Approx(8e6 * std::sqrt(2)).epsilon(1e-6));
    CHECK(total_length(clip_outside({diagonal}, r)) == Approx(4e6 * std::sqrt(2)).epsilon(1e-6));
  }
  for (const Polyline& along :
       {Polyline{{-kMm, 0}, {11 * kMm, 0}}, Polyline{{-kMm, 10 * kMm}, {11 * kMm, 10 * kMm}},
        Polyline{{0, -kMm}, {0, 11 * kMm}}, Polyline{{10 * kMm, 11 * kMm}, {10 * kMm, -kMm}},
        Polyline{{-kMm, 4 * kMm}, {11 * kMm, 4 * kMm}}}) {
    const double in = total_length(clip_inside({along}, r));
    CHECK(in + total_length(clip_outside({along}, r)) == 12e6);
    // Along an edge a line is inside or outside as a whole stretch.
    CHECK((in == 0 || in == 10e6 || in == 8e6));
  }
}

TEST_CASE("a polyline with corners on the border changes sides only where it truly does") {
  const Regions r{{make_rectangle({0, 0}, {10 * kMm, 10 * kMm}), {}}};
  // Touches the right border from inside, the left one from inside, then leaves through the top.
  const Polyline line{{5 * kMm, kMm}, {10 * kMm, 2 * kMm}, {0, 4 * kMm}, {5 * kMm, 12 * kMm}};
  const double in = total_length(clip_inside({line}, r));
  const double out = total_length(clip_outside({line}, r));
  CHECK(in + out == Approx(length(line)));
  CHECK(out == Approx(std::hypot(1.25, 2) * 1e6).epsilon(1e-6));
}

TEST_CASE("inside and outside add up to the line, piece by piece on the right side") {
  std::mt19937 random(5);
  // A coarse grid makes corners on lines and shared edges common.
  std::uniform_int_distribution<Coord> any(-12, 12);
  std::size_t pieces = 0;
  for (int round = 0; round < 200; ++round) {
    auto draw = [&](int n) {
      std::vector<Point> points;
      for (int i = 0; i < n; ++i) points.push_back({any(random) * kMm, any(random) * kMm});
      return points;
    };
    const Regions r = unite(Rings{draw(9), draw(5)});
    Polylines lines;
    for (int i = 0; i < 5; ++i) lines.push_back(draw(4));
    const Polylines in = clip_inside(lines, r);
    const Polylines out = clip_outside(lines, r);
    pieces += in.size();
    CHECK(total_length(in) + total_length(out) == Approx(total_length(lines)).epsilon(1e-6));
    auto on_side = [&](const Polylines& list, bool inside) {
      const Regions shrunk = offset(r, inside ? 10 : -10);
      for (const Polyline& l : list)
        for (std::size_t i = 1; i < l.size(); ++i) {
          const Point mid{(l[i - 1].x + l[i].x) / 2, (l[i - 1].y + l[i].y) / 2};
          bool within = false;
          for (const Region& region : shrunk) within |= contains(region, mid);
          INFO(Svg().add(r).add(list).add(mid).str());
          REQUIRE(within == inside);
        }
    };
    on_side(in, true);
    on_side(out, false);
  }
  CHECK(pieces > 1000);
}

}  // namespace voidpath::geom

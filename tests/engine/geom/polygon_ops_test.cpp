#include "engine/geom/polygon_ops.h"

#include "engine/geom/svg.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace voidpath::geom {

namespace {

constexpr Coord kMm = 1'000'000;

Ring square(Coord x, Coord y, Coord side) { return make_rectangle({x, y}, {x + side, y + side}); }

/// A square of 20 mm with a hole of 10 mm, and an island of 4 mm in it.
Regions framed() {
  Ring hole = square(-5 * kMm, -5 * kMm, 10 * kMm);
  reverse(hole);
  return {{square(-10 * kMm, -10 * kMm, 20 * kMm), {hole}}, {square(-2 * kMm, -2 * kMm, 4 * kMm), {}}};
}

/// Closed wander: self-intersecting.
Ring wander(std::mt19937& random, int points, Coord reach) {
  std::uniform_int_distribution<Coord> any(-reach, reach);
  Ring ring;
  for (int i = 0; i < points; ++i) ring.push_back({any(random), any(random)});
  return ring;
}

/// Star-shaped blob around a centre.
Ring blob(std::mt19937& random, Point centre, Coord radius, int points) {
  std::uniform_real_distribution<double> any(0.4, 1.0);
  Ring ring;
  for (int i = 0; i < points; ++i) {
    const double a = 2 * M_PI * i / points;
    const double r = static_cast<double>(radius) * any(random);
    ring.push_back({centre.x + std::llround(r * std::cos(a)), centre.y + std::llround(r * std::sin(a))});
  }
  return ring;
}

void require_well_formed(const Regions& regions) {
  for (const Region& r : regions) {
    REQUIRE(r.outer.size() >= 3);
    REQUIRE(area(r.outer) > 0);
    for (const Ring& hole : r.holes) {
      REQUIRE(hole.size() >= 3);
      REQUIRE(area(hole) < 0);
      REQUIRE(contains(r.outer, hole.front()));
    }
  }
}

/// nm² lost or won when corners are rounded to whole nm: half a nm along the whole outline.
double rounding_area(const Regions& regions) {
  double sum = 1;
  for (const Ring& ring : rings_of(regions)) sum += perimeter(ring);
  return sum;
}

}  // namespace

TEST_CASE("areas and containment of hand-made regions") {
  const Regions f = framed();
  CHECK(area(f) == (400 - 100 + 16) * 1e12);
  CHECK(contains(f[0], {-10 * kMm, 0}));
  CHECK(contains(f[0], {-5 * kMm, 0}));
  CHECK_FALSE(contains(f[0], {0, 0}));
  CHECK_FALSE(contains(f[0], {-10 * kMm - 1, 0}));
  CHECK(contains(f[1], {0, 0}));
  CHECK(perimeter(f[1].outer) == 16e6);
  CHECK(bounds(f) == Box{{-10 * kMm, -10 * kMm}, {10 * kMm, 10 * kMm}});
  CHECK_FALSE(bounds(Regions{}).has_value());
  // A triangle of one square nm far out keeps its sign.
  const Coord far = 1'000'000'000;
  CHECK(area(Ring{{far, far}, {far + 1, far}, {far, far + 1}}) == 0.5);
  CHECK(area(Ring{{far, far}, {far, far + 1}, {far + 1, far}}) == -0.5);
}

TEST_CASE("a point on any part of the border is contained") {
  const Ring ring{{0, 0}, {10, 0}, {10, 10}, {5, 5}, {0, 10}};
  for (std::size_t i = 0; i < ring.size(); ++i) CHECK(contains(ring, ring[i]));
  CHECK(contains(ring, {7, 0}));
  CHECK(contains(ring, {7, 7}));
  CHECK(contains(ring, {0, 3}));
  CHECK(contains(ring, {5, 4}));
  CHECK_FALSE(contains(ring, {5, 6}));
  CHECK_FALSE(contains(ring, {-1, 0}));
  CHECK_FALSE(contains(ring, {11, 0}));
}

TEST_CASE("unite nests islands in holes and orients rings") {
  Rings shuffled = rings_of(framed());
  std::swap(shuffled[0], shuffled[2]);
  const Regions r = unite(shuffled);
  require_well_formed(r);
  REQUIRE(r.size() == 2);
  CHECK(area(r) == area(framed()));
}

TEST_CASE("fill rules") {
  const Ring outer = square(0, 0, 10 * kMm);
  const Ring inner = square(2 * kMm, 2 * kMm, 4 * kMm);
  CHECK(area(unite(Rings{outer, inner}, FillRule::non_zero)) == 100e12);
  CHECK(area(unite(Rings{outer, inner}, FillRule::even_odd)) == 84e12);
  Ring turned = inner;
  reverse(turned);
  CHECK(area(unite(Rings{outer, turned}, FillRule::non_zero)) == 84e12);
  CHECK(area(unite(Rings{turned}, FillRule::non_zero)) == 16e12);
  CHECK(unite(Rings{turned}, FillRule::positive).empty());
}

TEST_CASE("laws of union, difference and intersection on wanderings") {
  std::mt19937 random(7);
  int not_empty = 0;
  for (int round = 0; round < 60; ++round) {
    const Regions a = unite(Rings{wander(random, 12, 20 * kMm), blob(random, {0, 0}, 10 * kMm, 20)});
    const Regions b = unite(Rings{wander(random, 12, 20 * kMm)});
    const Regions sum = unite(a, b);
    const Regions both = intersect(a, b);
    const Regions less = subtract(a, b);
    for (const Regions* r : {&a, &b, &sum, &both, &less}) require_well_formed(*r);
    const double slack = rounding_area(a) + rounding_area(b) + rounding_area(sum);
    CHECK(std::abs(area(a) + area(b) - area(sum) - area(both)) <= slack);
    CHECK(std::abs(area(a) - area(both) - area(less)) <= slack);
    CHECK(std::abs(area(intersect(less, b))) <= slack);
    // Uniting again changes nothing but what rounding may have left.
    CHECK(std::abs(area(unite(rings_of(sum), FillRule::positive)) - area(sum)) <= slack);
    CHECK(std::abs(area(unite(sum, a)) - area(sum)) <= slack);
    not_empty += !both.empty();
  }
  CHECK(not_empty > 50);
}

TEST_CASE("regions that do not meet are united, cut and intersected without change") {
  const Regions a = framed();
  Regions b = framed();
  translate(b, {50 * kMm, 0});
  CHECK(area(unite(a, b)) == 2 * area(a));
  CHECK(subtract(a, b) == a);
  CHECK(intersect(a, b).empty());
  CHECK(unite(a, Regions{}) == a);
  CHECK(unite(Regions{}, a) == a);
  CHECK(subtract(a, a).empty());
}

TEST_CASE("regions that touch along an edge unite into one") {
  const Regions a{{square(0, 0, kMm), {}}};
  const Regions b{{square(kMm, 0, kMm), {}}};
  const Regions sum = unite(a, b);
  REQUIRE(sum.size() == 1);
  CHECK(area(sum) == 2e12);
}

TEST_CASE("offset of a square has its closed forms") {
  const Regions s{{square(0, 0, 10 * kMm), {}}};
  CHECK(area(offset(s, kMm)) == 144e12);
  CHECK(area(offset(s, -kMm)) == 64e12);
  CHECK(area(offset(s, kMm, Join::round)) == Approx((100 + 40 + M_PI) * 1e12).epsilon(2e-4));
  CHECK(offset(s, 0) == s);
  CHECK(offset(s, -5 * kMm).empty());
  CHECK(offset({}, kMm).empty());
}

TEST_CASE("an offset grows outlines and shrinks holes, and splits and merges them") {
  const Regions f = framed();
  CHECK(area(offset(f, kMm)) == (22. * 22 - 8 * 8 + 6 * 6) * 1e12);
  CHECK(area(offset(f, -kMm)) == (18. * 18 - 12 * 12 + 2 * 2) * 1e12);
  CHECK(offset(f, 2 * kMm).size() == 1);
  CHECK(offset(f, -5 * kMm / 2).empty());
}

TEST_CASE("growing never loses area, and joins rank miter, square, round") {
  std::mt19937 random(11);
  for (int round = 0; round < 30; ++round) {
    const Regions r = unite(Rings{blob(random, {0, 0}, 20 * kMm, 30), wander(random, 5, 25 * kMm)});
    REQUIRE_FALSE(r.empty());
    double before = area(r);
    for (const Coord delta : {kMm / 100, kMm / 5, kMm, 3 * kMm}) {
      const double rounded = area(offset(r, delta, Join::round));
      const double squared = area(offset(r, delta, Join::square));
      // Clipper squares a miter beyond its limit off at delta, so a limit nothing reaches is the clean order.
      const double mitered = area(offset(r, delta, Join::miter, 1000));
      CHECK(rounded > before);
      CHECK(squared >= rounded * (1 - 1e-6));
      CHECK(mitered >= squared * (1 - 1e-6));
      CHECK(area(offset(r, -delta)) < area(r));
      before = rounded;
      require_well_formed(offset(r, -delta));
    }
  }
}

TEST_CASE("a round offset stays within its tolerance of the true distance") {
  const Regions dot{{square(0, 0, 1000), {}}};
  for (const Coord delta : {kMm / 10, kMm, 10 * kMm}) {
    const Regions disc = offset(dot, delta, Join::round);
    REQUIRE(disc.size() == 1);
    const Ring& ring = disc[0].outer;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[(i + 1) % ring.size()];
      const Point mid{(a.x + b.x) / 2, (a.y + b.y) / 2};
      const Point nearest{std::clamp<Coord>(mid.x, 0, 1000), std::clamp<Coord>(mid.y, 0, 1000)};
      CHECK(distance(mid, nearest) >= static_cast<double>(delta) - 5010);
      CHECK(distance(mid, nearest) <= static_cast<double>(delta) + 10);
    }
  }
}

TEST_CASE("opening removes what is thin, closing fills what is narrow") {
  // Two squares joined by a bar of 0.4 mm.
  const Regions barbell = unite(Rings{square(0, 0, 5 * kMm), square(10 * kMm, 0, 5 * kMm),
                                      make_rectangle({4 * kMm, 2 * kMm}, {11 * kMm, 2 * kMm + 400'000})});
  REQUIRE(barbell.size() == 1);
  const Regions opened = open(barbell, 300'000);
  CHECK(opened.size() == 2);
  CHECK(area(opened) == Approx(50e12));
  CHECK(open(barbell, 100'000).size() == 1);

  const Regions slit{{square(0, 0, 5 * kMm), {}}, {square(5 * kMm + 300'000, 0, 5 * kMm), {}}};
  CHECK(close(slit, 200'000).size() == 1);
  CHECK(close(slit, 100'000).size() == 2);
  std::mt19937 random(3);
  for (int round = 0; round < 20; ++round) {
    const Regions r = unite(Rings{blob(random, {0, 0}, 20 * kMm, 40)});
    const Regions o = open(r, kMm / 2);
    const Regions c = close(r, kMm / 2);
    CHECK(area(subtract(o, offset(r, 50))) <= rounding_area(r));
    CHECK(area(subtract(r, offset(c, 50))) <= rounding_area(r));
    CHECK(area(o) <= area(r));
    CHECK(area(c) >= area(r));
    const Regions rounded = open(r, kMm / 2, Join::round);
    CHECK(area(open(rounded, kMm / 2, Join::round)) == Approx(area(rounded)).epsilon(1e-3));
  }
}

TEST_CASE("what is narrower than it is moved inwards goes, and nothing else") {
  for (const double turn : {0.0, 0.1, 0.3, 0.7, 1.2}) {
    // A bar 2 mm wide, and one with a hole as wide.
    const auto bar = [&](double half_width, double half_length) {
      Ring ring;
      for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        const double u = x * half_length, v = y * half_width;
        ring.push_back({from_mm(std::cos(turn) * u - std::sin(turn) * v),
                        from_mm(std::sin(turn) * u + std::cos(turn) * v)});
      }
      return ring;
    };
    const Regions plain{{bar(1, 5), {}}};
    CHECK(offset(plain, -from_mm(1.001)).empty());
    CHECK(area(offset(plain, -from_mm(0.99))) == Approx(0.02e6 * 8.02e6).epsilon(0.01));
    Ring hole = bar(1, 5);
    reverse(hole);
    const Regions framed_bar{{bar(4, 8), {hole}}};
    REQUIRE(offset(framed_bar, from_mm(1.001)).size() == 1);
    CHECK(offset(framed_bar, from_mm(1.001))[0].holes.empty());
    CHECK(offset(framed_bar, from_mm(0.99))[0].holes.size() == 1);
  }
}

TEST_CASE("small regions and holes go") {
  const Regions f = framed();
  CHECK(remove_small(f, 17e12).size() == 1);
  CHECK(remove_small(f, 17e12)[0].holes.size() == 1);
  CHECK(remove_small(f, 101e12)[0].holes.empty());
  CHECK(remove_small(f, 1e12) == f);
}

TEST_CASE("simplify keeps within its tolerance and unites what it crossed") {
  Regions disc{{make_circle({0, 0}, 10 * kMm, 2000), {}}};
  const Regions s = simplify(disc, 10'000);
  REQUIRE(s.size() == 1);
  CHECK(s[0].outer.size() <= 128);
  CHECK(s[0].outer.size() > 60);
  const Regions outside = subtract(disc, offset(s, 10'100));
  const Regions added = subtract(s, offset(disc, 10'100));
  CHECK(outside.empty());
  CHECK(added.empty());
  CHECK(simplify(disc, 0) == disc);

  // The start of the ring does not matter.
  Regions turned = disc;
  std::rotate(turned[0].outer.begin(), turned[0].outer.begin() + 777, turned[0].outer.end());
  CHECK(simplify(turned, 10'000) == s);

  // A thin ring of 5 µm wall whose shortcuts cross.
  Ring hole = make_circle({0, 0}, 10 * kMm - 5'000, 1999);
  reverse(hole);
  disc[0].holes.push_back(hole);
  const Regions thin = simplify(disc, 20'000);
  require_well_formed(thin);
  CHECK(area(thin) <= 2 * area(disc) + 20'000 * 2 * M_PI * 1e7);

  const Polyline zigzag{{0, 0}, {kMm, 1000}, {2 * kMm, -1000}, {3 * kMm, 0}, {3 * kMm, kMm}};
  CHECK(simplify(zigzag, 2000) == Polyline{{0, 0}, {3 * kMm, 0}, {3 * kMm, kMm}});
  CHECK(simplify(zigzag, 500) == zigzag);
}

TEST_CASE("a drawing holds all that was added") {
  const std::string svg = Svg().add(framed()).add(Polylines{{{0, 0}, {kMm, kMm}}}).add(Point{0, 0}).str();
  CHECK(svg.find("viewBox=\"-11 -11 22 22\"") != std::string::npos);
  CHECK(svg.find("M0 -0L1 -1") != std::string::npos);
  CHECK(svg.find("circle") != std::string::npos);
}

}  // namespace voidpath::geom

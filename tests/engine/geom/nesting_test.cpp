#include "engine/geom/nesting.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace voidpath::geom {

namespace {

constexpr Coord kMm = 1'000'000;

Ring square(Coord centre_x, Coord centre_y, Coord half, bool clockwise = false) {
  Ring r = make_rectangle({centre_x - half, centre_y - half}, {centre_x + half, centre_y + half});
  if (clockwise) reverse(r);
  return r;
}

/// Whether any two edges touch, by looking at all pairs.
bool any_touch_brute(const Rings& rings) {
  struct Piece {
    Point a, b;
    std::size_t ring, index, count;
  };
  std::vector<Piece> all;
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (std::size_t i = 0; i < rings[r].size(); ++i)
      all.push_back({rings[r][i], rings[r][(i + 1) % rings[r].size()], r, i, rings[r].size()});
  auto cross = [](Point o, Point a, Point b) {
    const auto v = static_cast<long double>(a.x - o.x) * static_cast<long double>(b.y - o.y) -
                   static_cast<long double>(a.y - o.y) * static_cast<long double>(b.x - o.x);
    return v > 0 ? 1 : v < 0 ? -1 : 0;
  };
  auto on = [&](Point a, Point b, Point p) {
    return cross(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
           std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
  };
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = i + 1; k < all.size(); ++k) {
      const Piece& s = all[i];
      const Piece& t = all[k];
      if (s.ring == t.ring && (s.index + 1) % s.count == t.index) {
        if (on(s.a, s.b, t.b) || on(t.a, t.b, s.a)) return true;
      } else if (s.ring == t.ring && (t.index + 1) % t.count == s.index) {
        if (on(s.a, s.b, t.a) || on(t.a, t.b, s.b)) return true;
      } else if ((cross(s.a, s.b, t.a) * cross(s.a, s.b, t.b) < 0 &&
                  cross(t.a, t.b, s.a) * cross(t.a, t.b, s.b) < 0) ||
                 on(s.a, s.b, t.a) || on(s.a, s.b, t.b) || on(t.a, t.b, s.a) || on(t.a, t.b, s.b)) {
        return true;
      }
    }
  return false;
}

}  // namespace

TEST_CASE("touching edges are found wherever they are") {
  CHECK_FALSE(any_edges_touch({square(0, 0, kMm)}));
  CHECK_FALSE(any_edges_touch({square(0, 0, kMm), square(0, 0, kMm - 1)}));
  CHECK(any_edges_touch({square(0, 0, kMm), square(2 * kMm, 0, kMm)}));        // side on side
  CHECK(any_edges_touch({square(0, 0, kMm), square(2 * kMm, 2 * kMm, kMm)}));  // corner on corner
  CHECK_FALSE(any_edges_touch({square(0, 0, kMm), square(2 * kMm + 1, 0, kMm)}));
  CHECK(any_edges_touch({{{0, 0}, {kMm, kMm}, {kMm, 0}, {0, kMm}}}));          // bow tie
  CHECK(any_edges_touch({{{0, 0}, {kMm, 0}, {kMm / 2, 0}, {kMm / 2, kMm}}}));  // folds back
  CHECK(any_edges_touch({{{0, 0}, {kMm, 0}, {kMm, 0}, {0, kMm}}}));            // a corner twice
  CHECK(any_edges_touch({{{0, 0}, {kMm, 0}}}));
}

TEST_CASE("touching edges are found as by looking at all pairs") {
  std::mt19937 random(17);
  int touching = 0;
  int free = 0;
  for (int round = 0; round < 3000; ++round) {
    // Few points on a wide or a narrow grid: touching and free cases are both common.
    const Coord reach = round % 2 == 0 ? 6 : 100'000;
    std::uniform_int_distribution<Coord> any(-reach, reach);
    Rings rings(1 + static_cast<std::size_t>(round) % 3);
    for (Ring& ring : rings) {
      const Point at{any(random) * 4, any(random) * 4};
      for (int i = 0; i < 3 + round % 2; ++i) ring.push_back({at.x + any(random), at.y + any(random)});
    }
    const bool expected = any_touch_brute(rings);
    CHECK(any_edges_touch(rings) == expected);
    ++(expected ? touching : free);
  }
  CHECK(touching > 500);
  CHECK(free > 500);
}

TEST_CASE("nesting follows the winding of the rings") {
  // Outer, hole, island, hole in the island.
  const Rings four{square(0, 0, 8 * kMm), square(0, 0, 6 * kMm, true), square(0, 0, 4 * kMm),
                   square(0, 0, 2 * kMm, true)};
  const auto r = nest_if_disjoint(four, FillRule::non_zero);
  REQUIRE(r.has_value());
  REQUIRE(r->size() == 2);
  CHECK((*r)[0].holes.size() == 1);
  CHECK((*r)[1].holes.size() == 1);
  CHECK(area(*r) == (256 - 144 + 64 - 16) * 1e12);

  // The same way round twice is filled through; the inner ring is no border.
  const auto through = nest_if_disjoint({square(0, 0, 4 * kMm), square(0, 0, 2 * kMm)}, FillRule::non_zero);
  REQUIRE(through.has_value());
  CHECK(*through == Regions{{square(0, 0, 4 * kMm), {}}});
  // Clockwise alone is filled too, and comes back counter-clockwise.
  const auto turned = nest_if_disjoint({square(0, 0, 4 * kMm, true)}, FillRule::non_zero);
  REQUIRE(turned.has_value());
  CHECK(area(*turned) == 64e12);
  CHECK(nest_if_disjoint({square(0, 0, 4 * kMm, true)}, FillRule::positive)->empty());
  CHECK(nest_if_disjoint({}, FillRule::non_zero)->empty());
  CHECK_FALSE(nest_if_disjoint({square(0, 0, kMm), square(kMm, 0, kMm)}, FillRule::non_zero).has_value());
}

TEST_CASE("nesting and clipping agree") {
  std::mt19937 random(23);
  std::uniform_int_distribution<Coord> where(-30 * kMm, 30 * kMm);
  std::uniform_int_distribution<Coord> size(kMm / 2, 12 * kMm);
  int nested = 0;
  for (int round = 0; round < 400; ++round) {
    Rings rings;
    for (int i = 0; i < 6; ++i) {
      rings.push_back(make_circle({where(random), where(random)}, size(random), 12));
      if (random() % 2 == 0) reverse(rings.back());
    }
    for (const FillRule rule : {FillRule::non_zero, FillRule::even_odd, FillRule::positive}) {
      const auto direct = nest_if_disjoint(rings, rule);
      if (!direct) continue;
      ++nested;
      // A crossing far off makes the clipper do the same rings.
      Rings forced = rings;
      forced.push_back({{90 * kMm, 0}, {91 * kMm, 0}, {91 * kMm, kMm}, {90 * kMm, kMm}});
      forced.push_back(forced.back());
      const Regions clipped = unite(forced, rule);
      const double extra = rule == FillRule::even_odd ? 0 : 1e12;
      CHECK(area(*direct) + extra == area(clipped));
      CHECK(direct->size() + (extra > 0 ? 1 : 0) == clipped.size());
    }
  }
  CHECK(nested > 50);
}

}  // namespace voidpath::geom

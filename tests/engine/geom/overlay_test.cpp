#include "engine/geom/overlay.h"

#include "engine/geom/arrangement.h"
#include "engine/geom/predicates.h"
#include "engine/geom/svg.h"

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

/// Rings with corners on a lattice: edges lie on one another, corners on edges, rings run back on themselves.
Rings lattice_rings(std::mt19937& random, std::size_t count, Coord pitch, Coord reach) {
  std::uniform_int_distribution<Coord> any(-reach, reach);
  Rings rings(count);
  for (Ring& ring : rings) {
    const std::size_t n = 3 + random() % 5;
    for (std::size_t i = 0; i < n; ++i) ring.push_back({any(random) * pitch, any(random) * pitch});
  }
  return rings;
}

std::vector<const Ring*> pointers(const Rings& rings) {
  std::vector<const Ring*> out;
  for (const Ring& ring : rings) out.push_back(&ring);
  return out;
}

int winding(const Rings& rings, const Point& p) {
  int sum = 0;
  for (const Ring& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
      if ((a.y > p.y) == (b.y > p.y)) continue;
      if ((orientation(a, b, p) > 0) == (b.y > a.y)) sum += b.y > a.y ? 1 : -1;
    }
  return sum;
}

double distance_to(const Rings& rings, const Point& p) {
  double best = 1e300;
  for (const Ring& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point &a = ring[i], &b = ring[(i + 1) % ring.size()];
      const double dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
      const double px = static_cast<double>(p.x - a.x), py = static_cast<double>(p.y - a.y);
      const double t = std::clamp((px * dx + py * dy) / std::max(dx * dx + dy * dy, 1.0), 0.0, 1.0);
      best = std::min(best, std::hypot(px - t * dx, py - t * dy));
    }
  return best;
}

bool is_in(const Regions& regions, const Point& p) {
  return std::any_of(regions.begin(), regions.end(), [&](const Region& r) { return contains(r, p); });
}

bool on(const Point& a, const Point& b, const Point& p) {
  return orientation(a, b, p) == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
         std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y);
}

/// Whether the edges have more in common than ends, by their exact signs.
bool cross_or_touch(const Point& a, const Point& b, const Point& c, const Point& d) {
  if (orientation(a, b, c) * orientation(a, b, d) < 0 && orientation(c, d, a) * orientation(c, d, b) < 0)
    return true;
  auto inner = [](const Point& from, const Point& to, const Point& p) {
    return p != from && p != to && on(from, to, p);
  };
  return inner(a, b, c) || inner(a, b, d) || inner(c, d, a) || inner(c, d, b);
}

}  // namespace

TEST_CASE("arranged edges have only corners in common, and those are nodes") {
  std::mt19937 random(17);
  std::size_t cuts = 0;
  for (int round = 0; round < 1500; ++round) {
    // From a few nm, where every crossing is rounded far, to mm.
    const Coord pitch = round % 3 == 0 ? 1 : round % 3 == 1 ? 37 : kMm;
    const Rings rings = lattice_rings(random, 1 + random() % 4, pitch, round % 2 == 0 ? 7 : 1000);
    const auto lines = pointers(rings);
    const auto all = arrange(lines);
    REQUIRE(all.has_value());
    REQUIRE(all->first.size() == rings.size() + 1);
    struct Piece {
      std::size_t line;
      Arrangement::Corner a, b;
    };
    std::vector<Piece> pieces;
    for (std::size_t line = 0; line < rings.size(); ++line)
      for (std::uint32_t i = all->first[line]; i < all->first[line + 1]; ++i) {
        pieces.push_back({line, all->corners[i], all->corners[all->next(line, i)]});
        CHECK(distance_to({rings[line]}, all->corners[i].at) < 3);
      }
    for (std::size_t i = 0; i < pieces.size(); ++i)
      for (std::size_t k = i + 1; k < pieces.size(); ++k) {
        const Piece &s = pieces[i], &t = pieces[k];
        REQUIRE_FALSE(cross_or_touch(s.a.at, s.b.at, t.a.at, t.b.at));
        if (s.line != t.line && s.a.at == t.a.at) CHECK((s.a.node && t.a.node));
      }
    cuts += all->corners.size();
  }
  CHECK(cuts > 20'000);
}

TEST_CASE("what is filled is what is gone around") {
  std::mt19937 random(19);
  std::uniform_int_distribution<Coord> any(-9 * kMm, 9 * kMm);
  std::size_t probes = 0, inside = 0;
  for (int round = 0; round < 1200; ++round) {
    const Coord pitch = round % 2 == 0 ? kMm : kMm / 131;
    const Coord reach = round % 2 == 0 ? 8 : 1000;
    const Rings a = lattice_rings(random, 1 + random() % 4, pitch, reach);
    const Rings b = lattice_rings(random, random() % 4, pitch, reach);
    Rings both = a;
    both.insert(both.end(), b.begin(), b.end());
    const std::optional<Regions> results[] = {
        filled(a, FillRule::non_zero), filled(a, FillRule::even_odd),    filled(a, FillRule::positive),
        overlay(a, b, Overlay::unite), overlay(a, b, Overlay::subtract), overlay(a, b, Overlay::intersect)};
    for (const auto& r : results) {
      REQUIRE(r.has_value());
      for (const Region& region : *r) {
        CHECK(area(region.outer) > 0);
        for (const Ring& hole : region.holes) CHECK(area(hole) < 0);
      }
    }
    for (int i = 0; i < 40; ++i) {
      const Point p{any(random), any(random)};
      if (distance_to(both, p) < 4) continue;
      const int wa = winding(a, p), wb = winding(b, p);
      const bool expected[] = {wa != 0,          wa % 2 != 0,       wa > 0,
                               wa > 0 || wb > 0, wa > 0 && wb <= 0, wa > 0 && wb > 0};
      for (std::size_t k = 0; k < 6; ++k) {
        INFO(k << Svg().add(*results[k]).add(p).str());
        REQUIRE(is_in(*results[k], p) == expected[k]);
        ++probes;
        inside += expected[k] ? 1 : 0;
      }
    }
  }
  CHECK(probes > 250'000);
  CHECK(inside > 20'000);
}

TEST_CASE("rings that meet in corners stay apart") {
  // Corner on corner: two regions.
  const auto two = filled({square(0, 0, kMm), square(2 * kMm, 2 * kMm, kMm)}, FillRule::positive);
  REQUIRE(two.has_value());
  CHECK(two->size() == 2);
  // A hole that touches the border in a corner is a hole still.
  const Ring diamond{{0, -kMm}, {-kMm, 0}, {0, kMm}, {kMm, 0}};
  const auto pinched = filled({square(0, 0, kMm), diamond}, FillRule::positive);
  REQUIRE(pinched.has_value());
  CHECK(pinched->size() == 4);
  const Ring kite{{0, kMm}, {kMm / 2, 0}, {0, -kMm / 2}, {-kMm / 2, 0}};
  const auto holed = filled({square(0, 0, kMm), kite}, FillRule::positive);
  REQUIRE(holed.has_value());
  REQUIRE(holed->size() == 1);
  CHECK(holed->front().holes.size() == 1);
  CHECK(area(*holed) == 4e12 - area(Ring{kite.rbegin(), kite.rend()}));
  // Side on side: one.
  const auto one = filled({square(0, 0, kMm), square(2 * kMm, 0, kMm)}, FillRule::positive);
  REQUIRE(one.has_value());
  CHECK(*one == Regions{{one->front().outer, {}}});
  CHECK(one->front().outer.size() == 4);
  CHECK(area(*one) == 8e12);
}

TEST_CASE("nesting follows the winding of the rings") {
  // Outer, hole, island, hole in the island.
  const Rings four{square(0, 0, 8 * kMm), square(0, 0, 6 * kMm, true), square(0, 0, 4 * kMm),
                   square(0, 0, 2 * kMm, true)};
  const auto r = filled(four, FillRule::non_zero);
  REQUIRE(r.has_value());
  REQUIRE(r->size() == 2);
  CHECK((*r)[0].holes.size() == 1);
  CHECK((*r)[1].holes.size() == 1);
  CHECK(area(*r) == (256 - 144 + 64 - 16) * 1e12);
  // The same way round twice is filled through; the inner ring is no border. Points stay as they are.
  CHECK(filled({square(0, 0, 4 * kMm), square(0, 0, 2 * kMm)}, FillRule::non_zero) ==
        Regions{{square(0, 0, 4 * kMm), {}}});
  // Clockwise alone is filled too, and comes back counter-clockwise.
  CHECK(area(*filled({square(0, 0, 4 * kMm, true)}, FillRule::non_zero)) == 64e12);
  CHECK(filled({square(0, 0, 4 * kMm, true)}, FillRule::positive)->empty());
  CHECK(filled({}, FillRule::non_zero)->empty());
  // A ring and its reverse cancel.
  CHECK(filled({square(0, 0, kMm), square(0, 0, kMm, true)}, FillRule::non_zero)->empty());
  CHECK(overlay({square(0, 0, kMm)}, {square(0, 0, kMm)}, Overlay::subtract)->empty());
}

TEST_CASE("an overlay agrees with the clipper's") {
  std::mt19937 random(23);
  std::uniform_int_distribution<Coord> where(-30 * kMm, 30 * kMm);
  std::uniform_int_distribution<Coord> size(kMm / 2, 12 * kMm);
  int compared = 0;
  for (int round = 0; round < 300; ++round) {
    Rings rings;
    for (int i = 0; i < 6; ++i) {
      rings.push_back(make_circle({where(random), where(random)}, size(random), 60));
      if (random() % 2 == 0) reverse(rings.back());
    }
    for (const FillRule rule : {FillRule::non_zero, FillRule::even_odd, FillRule::positive}) {
      const auto own = filled(rings, rule);
      REQUIRE(own.has_value());
      // A ring beyond the overlay's reach makes the clipper do the same rings.
      Rings forced = rings;
      forced.push_back(square(1200 * kMm, 0, kMm));
      REQUIRE_FALSE(filled(forced, rule).has_value());
      const Regions clipped = unite(forced, rule);
      double border = 100;
      for (const Ring& ring : rings) border += perimeter(ring);
      CHECK(std::abs(area(*own) + 4e12 - area(clipped)) <= border);
      // Other rules fill opposite sides of a crossing, which the clipper may leave joined.
      if (rule == FillRule::positive) CHECK(own->size() + 1 == clipped.size());
      ++compared;
    }
  }
  CHECK(compared == 900);
}

}  // namespace voidpath::geom

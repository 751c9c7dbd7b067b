#include "engine/geom/offset_ring.h"

#include "engine/geom/arrangement.h"
#include "engine/geom/overlay.h"
#include "engine/geom/svg.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace voidpath::geom {

namespace {

constexpr Coord kMm = 1'000'000;

Regions blob(std::mt19937& random, Point centre, double radius_mm, int points, double roughness) {
  std::uniform_real_distribution<double> any(1 - roughness, 1.0);
  Ring ring;
  for (int i = 0; i < points; ++i) {
    const double a = 2 * M_PI * i / points;
    const double r = radius_mm * 1e6 * any(random);
    ring.push_back({centre.x + std::llround(r * std::cos(a)), centre.y + std::llround(r * std::sin(a))});
  }
  return {{ring, {}}};
}

/// Nearest distance from p to any edge of the regions, nm.
double distance_to_border(const Regions& regions, const Point& p) {
  double best = 1e300;
  for (const Ring& ring : rings_of(regions))
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[(i + 1) % ring.size()];
      const double dx = static_cast<double>(b.x - a.x);
      const double dy = static_cast<double>(b.y - a.y);
      const double px = static_cast<double>(p.x - a.x);
      const double py = static_cast<double>(p.y - a.y);
      const double t = std::clamp((px * dx + py * dy) / std::max(dx * dx + dy * dy, 1.0), 0.0, 1.0);
      best = std::min(best, std::hypot(px - t * dx, py - t * dy));
    }
  return best;
}

/// Whether edges of it cross beyond the corners that neighbours share.
bool crosses_itself(const Ring& ring) {
  const Ring* line = &ring;
  const auto cut = arrange({&line, 1});
  return !cut || cut->corners.size() != ring.size();
}

bool is_in(const Regions& regions, const Point& p) {
  return std::any_of(regions.begin(), regions.end(), [&](const Region& r) { return contains(r, p); });
}

}  // namespace

TEST_CASE("a ring's raw offset cuts corners where edges are long enough") {
  const OffsetStyle miter;
  const Ring square = make_rectangle({0, 0}, {kMm, kMm});
  CHECK(raw_offset_ring(square, 100, miter) == make_rectangle({-100, -100}, {kMm + 100, kMm + 100}));
  CHECK(raw_offset_ring(square, -100, miter) == make_rectangle({100, 100}, {kMm - 100, kMm - 100}));
  CHECK(filled({raw_offset_ring(square, -kMm / 2, miter)}, FillRule::positive)->empty());
  CHECK(filled({raw_offset_ring(square, -kMm, miter)}, FillRule::positive)->empty());
  // A notch of 0.2 mm closes when the outline grows by more than half of that.
  const Ring notched{
      {0, 0},         {kMm, 0}, {kMm, kMm}, {600'000, kMm}, {600'000, 500'000}, {400'000, 500'000},
      {400'000, kMm}, {0, kMm}};
  CHECK_FALSE(crosses_itself(raw_offset_ring(notched, 90'000, miter)));
  const Ring closed = raw_offset_ring(notched, 110'000, miter);
  CHECK(crosses_itself(closed));
  CHECK(area(*filled({closed}, FillRule::positive)) == 1.22e6 * 1.22e6);
  // Clockwise rings are holes: growing the area shrinks them.
  Ring hole = square;
  reverse(hole);
  CHECK(area(raw_offset_ring(hole, 100, miter)) == -(1e6 - 200) * (1e6 - 200));
  // Repeated points count once.
  CHECK(raw_offset_ring({{0, 0}, {kMm, 0}, {0, 0}}, 100, miter).empty());
  CHECK(raw_offset_ring({{0, 0}, {0, 0}, {kMm, 0}, {kMm, kMm}, {0, kMm}, {0, 0}}, 100, miter) ==
        make_rectangle({-100, -100}, {kMm + 100, kMm + 100}));
}

TEST_CASE("offsets are where the distance says they are") {
  std::mt19937 random(31);
  std::size_t probes = 0;
  int plain = 0;
  int crossing = 0;
  for (int round = 0; round < 60; ++round) {
    // A body with holes and a neighbour; rough ones lose edges, smooth ones do not, some touch.
    const double roughness = 0.05 * (round % 7);
    Regions r = subtract(blob(random, {0, 0}, 20, round % 2 ? 40 : 120, roughness),
                         blob(random, {-8 * kMm, 0}, 5, 16, roughness));
    r = subtract(r, blob(random, {7 * kMm, kMm}, 6, 24, roughness));
    r = unite(r, blob(random, {30 * kMm, 0}, 9, 20, roughness));
    for (const Coord delta : {kMm / 5, -kMm / 5, 6 * kMm / 5, -6 * kMm / 5, -3 * kMm}) {
      const Regions moved = offset(r, delta, Join::round);
      ++(crosses_itself(raw_offset_ring(r[0].outer, delta, {Join::round, 2, 5000})) ? crossing : plain);
      std::uniform_int_distribution<Coord> x(-25 * kMm, 45 * kMm);
      std::uniform_int_distribution<Coord> y(-25 * kMm, 25 * kMm);
      for (int i = 0; i < 200; ++i) {
        const Point p{x(random), y(random)};
        const double depth = (is_in(r, p) ? 1 : -1) * distance_to_border(r, p) + static_cast<double>(delta);
        // Nearer to the border than arcs are exact, nothing is said.
        if (std::abs(depth) < 5100) continue;
        ++probes;
        INFO(Svg().add(r, "grey").add(moved).add(p).str());
        REQUIRE(is_in(moved, p) == (depth > 0));
      }
    }
  }
  CHECK(probes > 50'000);
  CHECK(plain > 30);
  CHECK(crossing > 50);
}

TEST_CASE("no corner of what shrinks stays behind where the border has a step of a few nm") {
  std::mt19937 random(7);
  std::uniform_int_distribution<Coord> jog(-40, 40), step(20'000, 900'000), tread(1, 3);
  const Coord by = 225'000;
  for (int round = 0; round < 400; ++round) {
    Ring ring{{0, 0}, {5 * kMm, 0}, {5 * kMm, 5 * kMm}, {0, 5 * kMm}};
    for (Coord y = 5 * kMm - step(random); y > 0; y -= step(random)) {
      ring.push_back({jog(random), y});
      ring.push_back({ring.back().x - tread(random), y});
    }
    const Regions square{{ring, {}}};
    const Regions small = offset(square, -by);
    REQUIRE(small.size() == 1);
    double least = 1e300;
    for (const Point& p : small.front().outer) least = std::min(least, distance_to_border(square, p));
    CAPTURE(round);
    CHECK(least >= static_cast<double>(by) - 60);
  }
}

TEST_CASE("mitered and squared offsets agree with the clipper's") {
  std::mt19937 random(41);
  for (int round = 0; round < 80; ++round) {
    const double roughness = 0.02 * (round % 10);
    Regions r =
        subtract(blob(random, {0, 0}, 20, 30, roughness), blob(random, {-8 * kMm, 0}, 5, 16, roughness));
    for (const Join join : {Join::miter, Join::square})
      for (const Coord delta : {kMm / 5, -kMm / 5, kMm, -kMm}) {
        // A square beyond the reach of our own overlay sends everything through the clipper.
        const Regions moved = offset(r, delta, join);
        Regions with_far = r;
        with_far.push_back({make_rectangle({1200 * kMm, 0}, {1201 * kMm, kMm}), {}});
        Regions clipped = offset(with_far, delta, join);
        std::erase_if(clipped, [&](const Region& x) { return x.outer.front().x > 50 * kMm; });
        double border = 0;
        for (const Ring& ring : rings_of(moved)) border += perimeter(ring) + 1;
        CHECK(std::abs(area(moved) - area(clipped)) <= 2 * border);
        CHECK(area(subtract(moved, clipped)) <= 2 * border);
        CHECK(area(subtract(clipped, moved)) <= 2 * border);
      }
  }
}

}  // namespace voidpath::geom

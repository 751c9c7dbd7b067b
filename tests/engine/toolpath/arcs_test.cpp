#include "engine/gcode/estimate.h"
#include "engine/toolpath/emit/emit.h"
#include "engine/toolpath/emit/fit_arcs.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <sstream>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::Point;
using toolpath::Stroke;

namespace {

constexpr double kTolerance_mm = 0.025;

geom::Polyline arc_points(double radius_mm, double from, double to, int pieces) {
  geom::Polyline out;
  for (int i = 0; i <= pieces; ++i) {
    const double a = from + (to - from) * i / pieces;
    out.push_back(
        {geom::from_mm(100 + radius_mm * std::cos(a)), geom::from_mm(100 + radius_mm * std::sin(a))});
  }
  return out;
}

/// Of a point from the strokes, mm.
double distance_mm(const Point& start, const std::vector<Stroke>& strokes, const Point& p) {
  double best = 1e9;
  Point from = start;
  for (const Stroke& s : strokes) {
    const double px = geom::to_mm(p.x), py = geom::to_mm(p.y);
    if (s.turn == 0) {
      const double ax = geom::to_mm(from.x), ay = geom::to_mm(from.y);
      const double dx = geom::to_mm(s.to.x) - ax, dy = geom::to_mm(s.to.y) - ay;
      const double t = std::clamp(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
      best = std::min(best, std::hypot(px - ax - t * dx, py - ay - t * dy));
    } else {
      // Only of points within the sweep; all that are asked for are, or another stroke is nearer.
      const double cx = geom::to_mm(s.centre.x), cy = geom::to_mm(s.centre.y);
      const double a0 = std::atan2(geom::to_mm(from.y) - cy, geom::to_mm(from.x) - cx);
      const double a1 = std::atan2(geom::to_mm(s.to.y) - cy, geom::to_mm(s.to.x) - cx);
      auto ahead = [&](double a) {
        const double d = std::fmod(s.turn * (a - a0) + 4 * std::numbers::pi, 2 * std::numbers::pi);
        return d > 2 * std::numbers::pi - 1e-6 ? 0.0 : d;
      };
      if (ahead(std::atan2(py - cy, px - cx)) <= ahead(a1) + 1e-6)
        best = std::min(best, std::abs(std::hypot(px - cx, py - cy) -
                                       std::hypot(geom::to_mm(from.x) - cx, geom::to_mm(from.y) - cy)));
    }
    from = s.to;
  }
  return best;
}

}  // namespace

TEST_CASE("a finely cut arc becomes one arc, a polygon stays one") {
  for (const int turn : {1, -1}) {
    const auto strokes = toolpath::fit_arcs(arc_points(10, 0, turn * 4.0, 100), kTolerance_mm);
    REQUIRE(strokes.size() == 1);
    CHECK(strokes[0].turn == turn);
    CHECK(geom::to_mm(strokes[0].centre.x) == Approx(100).margin(1e-3));
    CHECK(geom::to_mm(strokes[0].centre.y) == Approx(100).margin(1e-3));
  }
  // A hexagon's corners lie on a circle, its sides don't.
  const auto hexagon = toolpath::fit_arcs(arc_points(10, 0, 2 * std::numbers::pi, 6), kTolerance_mm);
  CHECK(hexagon.size() == 6);
  for (const Stroke& s : hexagon) CHECK(s.turn == 0);
  // A full circle needs more than one arc, and closes.
  const geom::Polyline circle = arc_points(10, 0, 2 * std::numbers::pi, 200);
  const auto round = toolpath::fit_arcs(circle, kTolerance_mm);
  CHECK(round.size() >= 2);
  CHECK(round.size() <= 3);
  CHECK(round.back().to == circle.back());
}

TEST_CASE("neither the line nor its arcs leave the other by more than the tolerance") {
  std::mt19937 random(20);
  std::uniform_real_distribution<double> share(0, 1);
  std::size_t arcs = 0;
  for (int trial = 0; trial < 300; ++trial) {
    // Arcs and straights one after another, with noise below the tolerance.
    geom::Polyline line{{geom::from_mm(100), geom::from_mm(100)}};
    double x = 100, y = 100, heading = 6 * share(random);
    for (int part = 0; part < 5; ++part) {
      const double bend = (share(random) - 0.5) * (part % 2 == 0 ? 0.3 : 0.0);
      const double step = 0.2 + 2 * share(random);
      for (int k = 0; k < 20; ++k) {
        heading += bend;
        x += step * std::cos(heading) + 0.004 * share(random);
        y += step * std::sin(heading) + 0.004 * share(random);
        line.push_back({geom::from_mm(x), geom::from_mm(y)});
      }
    }
    const auto strokes = toolpath::fit_arcs(line, kTolerance_mm);
    CHECK(strokes.back().to == line.back());
    std::size_t at = 0;
    for (const Stroke& s : strokes) {
      CHECK(s.last > at);
      CHECK(line[s.last] == s.to);
      at = s.last;
      arcs += s.turn != 0;
    }
    for (std::size_t k = 1; k < line.size(); ++k) {
      const Point mid{(line[k - 1].x + line[k].x) / 2, (line[k - 1].y + line[k].y) / 2};
      CHECK(distance_mm(line[0], strokes, line[k]) <= kTolerance_mm + 1e-4);
      CHECK(distance_mm(line[0], strokes, mid) <= kTolerance_mm + 1e-4);
    }
  }
  CHECK(arcs > 300);
}

TEST_CASE("a cylinder with arcs has fewer lines, the same material and nearly the same time") {
  toolpath::PrintSettings s;
  s.slice.infill_density = 0;
  const auto stack = stack_of(4, 0.2, [](double) {
    geom::Ring ring = arc_points(15, 0, 2 * std::numbers::pi, 400);
    ring.pop_back();
    return geom::Regions{{ring, {}}};
  });
  const auto plan = toolpath::build(stack, s);
  std::ostringstream straight, curved;
  const auto without = toolpath::emit(plan, s, "", straight, {});
  s.machine.arcs = true;
  const auto with = toolpath::emit(plan, s, "", curved, {});
  CHECK(with.filament_mm == Approx(without.filament_mm).epsilon(1e-9));
  CHECK(curved.str().find("G3 ") != std::string::npos);
  CHECK(2 * curved.str().size() < straight.str().size());
  std::istringstream in_straight(straight.str()), in_curved(curved.str());
  const auto a = gcode::estimate(in_straight, {}), b = gcode::estimate(in_curved, {});
  CHECK(b.filament_mm == Approx(a.filament_mm).epsilon(1e-4));
  CHECK(b.extruding_mm == Approx(a.extruding_mm).epsilon(2e-3));
}

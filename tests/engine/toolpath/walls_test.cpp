#include "engine/toolpath/travel/order.h"
#include "engine/toolpath/walls/perimeters.h"
#include "engine/toolpath/walls/seam.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

TEST_CASE("as many walls as asked, around the outside and around holes, the inner ones first") {
  for (const int n : {1, 2, 3, 5}) {
    auto s = bare_settings();
    s.slice.perimeters = n;
    const auto plan = toolpath::build(cup_stack(40, 2, 12, 1), s);
    const auto& floor = plan.layers[2];
    CHECK(count(floor, Role::external_perimeter) == 1);
    CHECK(count(floor, Role::perimeter) == static_cast<std::size_t>(n - 1));
    const auto& wall = plan.layers[8];
    CHECK(count(wall, Role::external_perimeter) == 2);
    CHECK(count(wall, Role::perimeter) == static_cast<std::size_t>(2 * (n - 1)));
    if (n > 1) CHECK(wall.paths.front().role == Role::perimeter);
    s.slice.external_perimeters_first = true;
    CHECK(toolpath::build(cup_stack(40, 2, 12, 1), s).layers[8].paths.front().role ==
          Role::external_perimeter);
  }
}

TEST_CASE("walls lie half a bead inside the outline and one spacing apart") {
  const toolpath::BeadSize bead{0.45, 0.2};
  const auto p = toolpath::make_perimeters(rectangle(0, 0, 20, 10), 3, bead);
  REQUIRE(p.walls.size() == 1);
  REQUIRE(p.walls[0].size() == 3);
  for (int depth = 0; depth < 3; ++depth) {
    const auto box = *geom::bounds(p.walls[0][static_cast<std::size_t>(depth)].ring);
    CHECK(geom::to_mm(box.min.x) == Approx(0.225 + depth * bead.spacing_mm()).margin(0.003));
    CHECK(geom::to_mm(box.max.y) == Approx(10 - 0.225 - depth * bead.spacing_mm()).margin(0.003));
  }
  CHECK(p.gaps.empty());
  CHECK(geom::to_mm(geom::bounds(p.inner)->min.x) == Approx(0.225 + 2.5 * bead.spacing_mm()).margin(0.003));
}

TEST_CASE("without walls, a strip of any width is printed: filled, or as a line") {
  auto s = bare_settings();
  s.slice.perimeters = 0;
  s.slice.infill_density = 1;
  for (const double width : {0.15, 0.25, 0.35, 0.38, 0.41, 0.44, 0.46, 0.6, 1.0}) {
    const auto plan = toolpath::build(box_stack(width, 8, 1), s);
    CAPTURE(width);
    for (std::size_t i = 1; i < plan.layers.size(); ++i) {
      CAPTURE(i);
      double length = 0;
      for (const auto& path : plan.layers[i].paths) length += length_mm(path);
      CHECK(length > 6);
    }
  }
}

TEST_CASE("without walls, a strip beside a wide area is printed as well") {
  auto s = bare_settings();
  s.slice.perimeters = 0;
  s.slice.infill_density = 1;
  for (const double width : {0.5, 0.6, 0.7, 0.8, 0.9}) {
    const auto stack = stack_of(1, 0.2, [&](double) {
      return geom::unite({rectangle(50, 50, 57.3, 60).outer, rectangle(50, 60, 50 + width, 68).outer,
                          rectangle(57.3, 50, 65, 50 + width).outer});
    });
    const auto plan = toolpath::build(stack, s);
    CAPTURE(width);
    for (std::size_t i = 1; i < plan.layers.size(); ++i) {
      const auto beads = covered(plan.layers[i], [](const toolpath::Path&) { return true; });
      const auto bare = geom::subtract(stack[i].regions, beads);
      CAPTURE(i);
      CHECK(geom::open(bare, from_mm(0.2)).empty());
    }
  }
}

TEST_CASE("without walls, skins and bridges that meet leave nothing bare between them or at the border") {
  auto s = bare_settings();
  s.slice.perimeters = 0;
  s.slice.infill_density = 1;
  // A cone's layers each have a ring of top skin, and so does what leans back; an L on three posts is bridged
  // both ways.
  const auto lean = stack_of(3, 0.2, [](double z) {
    return geom::Regions{rectangle(50 + 0.9 * z, 50, 65, 56), rectangle(70, 50, 78 - 2 * z, 50.6 + 2 * z)};
  });
  const auto corner = stack_of(3, 0.2, [](double z) {
    const geom::Regions posts{rectangle(50, 50, 53, 53), rectangle(60, 50, 63, 53),
                              rectangle(50, 60, 53, 63)};
    return z < 2 ? posts : geom::unite({rectangle(50, 50, 63, 53).outer, rectangle(50, 50, 53, 63).outer});
  });
  for (const auto& stack : {cone_stack(8, 4, 2), lean, corner}) {
    const auto plan = toolpath::build(stack, s);
    for (std::size_t i = 1; i < plan.layers.size(); ++i) {
      CAPTURE(i);
      const auto beads = covered(plan.layers[i], [](const toolpath::Path&) { return true; });
      const auto bare = geom::subtract(stack[i].regions, beads);
      CHECK(geom::open(bare, from_mm(0.17)).empty());
      for (const auto& path : plan.layers[i].paths) {
        const auto inside = geom::offset(stack[i].regions, -from_mm(0.5 * path.width_mm - 0.06));
        CHECK(geom::clip_outside({line_of(path)}, inside).empty());
      }
    }
  }
}

TEST_CASE("without walls, what is filled stays inside where a blade's tip is cut off short") {
  for (double tip = 0.1; tip < 0.9; tip += 0.1)
    for (const double slope : {0.5, 0.8, 1.2}) {
      const double half = tip / 2 + 4 * slope;
      const geom::Region blade{{{from_mm(50), from_mm(50 - tip / 2)},
                                {from_mm(54), from_mm(50 - half)},
                                {from_mm(54), from_mm(50 + half)},
                                {from_mm(50), from_mm(50 + tip / 2)}},
                               {}};
      CAPTURE(tip, slope);
      const auto p = toolpath::make_perimeters(blade, 0, {0.45, 0.2});
      CHECK(geom::area(p.inner) > 0.8 * geom::area(blade));
      CHECK(geom::open(geom::subtract(p.inner, {blade}), from_mm(0.001)).empty());
    }
}

TEST_CASE("beads never leave the outline") {
  auto s = bare_settings();
  for (const auto& stack : {cup_stack(30, 4, 1.7, 1), cone_stack(15, 6, 2), arch_stack(20, 10, 6, 2, 4)}) {
    const auto plan = toolpath::build(stack, s);
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
      geom::Polylines lines;
      for (const auto& path : plan.layers[i].paths) lines.push_back(line_of(path));
      const auto inside = geom::offset(stack[i].regions, -from_mm(0.12));
      CHECK(geom::clip_outside(lines, inside).empty());
    }
  }
}

TEST_CASE("a wall stays inside where a blade's tip is cut off short") {
  auto s = bare_settings();
  for (double tip = 0.05; tip < 0.5; tip += 0.05)
    for (const double angle : {0.9, 1.2, 1.5, 1.8}) {  // between the blade's sides, rad
      const double length = 4, half = tip / 2 + length * std::tan(angle / 2);
      const auto stack = stack_of(1, 0.2, [&](double) {
        return geom::Regions{{{{from_mm(50), from_mm(50 - tip / 2)},
                               {from_mm(50 + length), from_mm(50 - half)},
                               {from_mm(50 + length), from_mm(50 + half)},
                               {from_mm(50), from_mm(50 + tip / 2)}},
                              {}}};
      });
      const auto plan = toolpath::build(stack, s);
      std::size_t seen = 0;
      for (const auto& path : plan.layers[2].paths) {
        if (path.role != toolpath::Role::external_perimeter) continue;
        for (const geom::Point& p : path.points) {
          CAPTURE(tip, angle);
          CHECK(geom::to_mm(p.x) - 50 >= 0.5 * path.width_mm - 0.03);
          ++seen;
        }
      }
      CHECK(seen > 2);
    }
}

TEST_CASE("a solid's beads add up to its volume") {
  auto s = bare_settings();
  s.slice.infill_density = 1;
  const auto stack = cone_stack(15, 6, 8);
  double part = 0;
  for (const auto& layer : stack) part += geom::to_mm2(geom::area(layer.regions)) * layer.span.height_mm();
  CHECK(volume_mm3(toolpath::build(stack, s)) == Approx(part).epsilon(0.03));
}

TEST_CASE("seams: aligned ones stay, rear ones lie behind, corners are preferred") {
  auto s = bare_settings();
  s.slice.seam = toolpath::SeamPosition::aligned;
  auto plan = toolpath::build(box_stack(20, 20, 4), s);
  auto seam = [](const toolpath::LayerPlan& layer) {
    for (const auto& p : layer.paths)
      if (p.role == Role::external_perimeter) return p.points.front();
    return geom::Point{};
  };
  for (const auto& layer : plan.layers)
    CHECK(geom::distance(seam(layer), seam(plan.layers[0])) < 0.05 * geom::kNmPerMm);
  s.slice.seam = toolpath::SeamPosition::rear;
  plan = toolpath::build(cone_stack(15, 4, 12), s);
  for (const auto& layer : plan.layers) {
    const auto box = *geom::bounds(layer.outline);
    CHECK(geom::to_mm(box.max.y - seam(layer).y) < 0.6);
  }
  // An L: its inner corner hides a seam best.
  const geom::Ring l{{0, 0},
                     {from_mm(10), 0},
                     {from_mm(10), from_mm(4)},
                     {from_mm(4), from_mm(4)},
                     {from_mm(4), from_mm(10)},
                     {0, from_mm(10)}};
  toolpath::SeamChooser chooser(toolpath::SeamPosition::nearest);
  chooser.begin_layer();
  CHECK(chooser.choose(l, {from_mm(5), from_mm(5)}) == 3);
}

TEST_CASE("an order visits every stop once and is no longer than the order given") {
  std::vector<toolpath::Stop> stops;
  std::uint64_t seed = 42;
  auto next = [&] {
    return static_cast<geom::Coord>((seed = seed * 6364136223846793005ULL + 1442695040888963407ULL) >> 40);
  };
  for (int i = 0; i < 120; ++i) {
    const geom::Point a{next(), next()};
    stops.push_back({a, {a.x + 1000000, a.y}, i % 3 != 0, {}});
  }
  const auto seq = toolpath::order_stops(stops, {});
  std::vector<int> seen(stops.size(), 0);
  double ordered = 0, given = 0;
  geom::Point at{}, at_given{};
  for (std::size_t i = 0; i < seq.size(); ++i) {
    const auto& s = stops[seq[i].index];
    CHECK((!seq[i].reversed || s.reversible));
    ++seen[seq[i].index];
    ordered += geom::distance(at, seq[i].reversed ? s.out : s.in);
    at = seq[i].reversed ? s.in : s.out;
    given += geom::distance(at_given, stops[i].in);
    at_given = stops[i].out;
  }
  for (const int n : seen) CHECK(n == 1);
  CHECK(ordered < 0.3 * given);
}

TEST_CASE("loops are entered where the way is shortest") {
  // Squares in a row, 10 mm apart, their first corners far from the way along them.
  std::vector<toolpath::Stop> stops;
  for (int i = 0; i < 8; ++i) {
    const double x = 15.0 * i;
    geom::Ring square = rectangle(x, 0, x + 5, 5).outer;
    std::rotate(square.begin(), square.begin() + 2, square.end());
    stops.push_back(toolpath::loop_stop(square));
  }
  std::swap(stops[1], stops[6]);
  std::swap(stops[2], stops[4]);
  geom::Point at{from_mm(-10), 0};
  double sum = 0;
  for (const auto& v : toolpath::order_stops(stops, at)) {
    sum += geom::distance(at, v.in) / geom::kNmPerMm;
    at = v.in;
  }
  // 10 mm to the first; each loop is left where it was entered, so a square's width counts as well.
  CHECK(sum == Approx(10 + 7 * 15.0));
}

TEST_CASE("the order of a few stops is the best there is") {
  std::uint64_t seed = 7;
  auto next = [&] {
    return static_cast<geom::Coord>((seed = seed * 6364136223846793005ULL + 1442695040888963407ULL) >> 40);
  };
  int best_found = 0;
  for (int round = 0; round < 40; ++round) {
    std::vector<toolpath::Stop> stops;
    for (int i = 0; i < 6; ++i) stops.push_back({{next(), next()}, {next(), next()}, true, {}});
    auto length = [&](const std::vector<toolpath::Visit>& seq) {
      double sum = 0;
      geom::Point at{};
      for (const auto& v : seq) {
        const auto& s = stops[v.index];
        sum += geom::distance(at, v.reversed ? s.out : s.in);
        at = v.reversed ? s.in : s.out;
      }
      return sum;
    };
    const double found = length(toolpath::order_stops(stops, {}));
    double best = 1e300;
    std::vector<std::size_t> order{0, 1, 2, 3, 4, 5};
    do {
      for (unsigned turns = 0; turns < 64; ++turns) {
        std::vector<toolpath::Visit> seq;
        for (std::size_t k = 0; k < 6; ++k) seq.push_back({order[k], (turns >> k & 1U) != 0, {}});
        best = std::min(best, length(seq));
      }
    } while (std::next_permutation(order.begin(), order.end()));
    CHECK(found < 1.25 * best);
    best_found += found < 1.0001 * best ? 1 : 0;
  }
  CHECK(best_found >= 28);
}

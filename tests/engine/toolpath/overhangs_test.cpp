#include "engine/toolpath/overhang/overhangs.h"

#include "engine/toolpath/emit/pace.h"
#include "engine/toolpath/overhang/tips.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

/// A wall along y whose bead's middle lies `beyond` mm outside the layer below.
toolpath::Path wall_beyond(double beyond) {
  toolpath::Path path;
  path.role = Role::external_perimeter;
  path.points = {{from_mm(70 + beyond), from_mm(55)}, {from_mm(70 + beyond), from_mm(65)}};
  path.width_mm = 0.45;
  path.area_mm2 = 0.08;
  return path;
}

}  // namespace

TEST_CASE("a wall is slowed by how much of its bead hangs over air") {
  toolpath::PrintSettings s = bare_settings();
  s.speed.external_perimeter = 40;
  s.speed.overhang_25 = 30;
  s.speed.overhang_50 = 20;
  s.speed.overhang_75 = 10;
  s.speed.bridge = 35;
  const geom::Regions below{rectangle(50, 50, 70, 70)};
  const geom::Regions own{rectangle(50, 50, 71, 70)};
  // A bead 0.45 mm wide whose middle is d beyond the edge hangs by 0.5 + d / 0.45 of its width.
  struct Case {
    double hanging, speed;
    Role role;
  };
  for (const auto& c : {Case{0.05, 40, Role::external_perimeter}, Case{0.24, 40, Role::external_perimeter},
                        Case{0.26, 30, Role::external_perimeter}, Case{0.49, 30, Role::external_perimeter},
                        Case{0.51, 20, Role::external_perimeter}, Case{0.74, 20, Role::external_perimeter},
                        Case{0.76, 10, Role::overhang_perimeter}, Case{0.99, 10, Role::overhang_perimeter},
                        Case{1.01, 35, Role::overhang_perimeter}}) {
    CAPTURE(c.hanging);
    std::vector<toolpath::Path> paths{wall_beyond((c.hanging - 0.5) * 0.45)};
    toolpath::mark_overhangs(paths, own, below, {}, 0.45, s.speed);
    REQUIRE(paths.size() == 1);
    CHECK(paths[0].role == c.role);
    CHECK(toolpath::path_speed_mm_s(paths[0], 3, s) == c.speed);
  }
  s.speed.overhang_25 = s.speed.overhang_50 = 0;  // not slowed
  std::vector<toolpath::Path> paths{wall_beyond(0.2 * 0.45)};
  toolpath::mark_overhangs(paths, own, below, {}, 0.45, s.speed);
  CHECK(toolpath::path_speed_mm_s(paths[0], 3, s) == 40);
}

TEST_CASE("a wall that leaves the layer below is cut where its bead hangs more, and stays in one piece") {
  toolpath::PrintSettings s = bare_settings();
  s.speed.overhang_25 = 22;
  const geom::Regions below{rectangle(50, 50, 70, 70)};
  const geom::Regions own{rectangle(50, 50, 80, 70)};
  toolpath::Path path = wall_beyond(0);
  path.points = {{from_mm(60), from_mm(60)}, {from_mm(69), from_mm(60)}, {from_mm(79), from_mm(61)}};
  const double before = length_mm(path);
  std::vector<toolpath::Path> paths{path};
  // Bands are crossed within a fraction of a millimetre here: too short to be stretches of their own.
  toolpath::mark_overhangs(paths, own, below, {}, 0.45, s.speed);
  REQUIRE(paths.size() == 2);
  CHECK(paths[0].role == Role::external_perimeter);
  CHECK(paths[1].role == Role::overhang_perimeter);
  CHECK(paths[0].points.back() == paths[1].points.front());
  CHECK(length_mm(paths[0]) + length_mm(paths[1]) == Approx(before));
  CHECK(geom::to_mm(paths[1].points.front().x) == Approx(70).margin(0.6));
}

TEST_CASE("stretches that hang by more and less count together") {
  const geom::Regions below{rectangle(50, 50, 70, 70)};
  const geom::Regions own{rectangle(50, 50, 71, 70)};
  toolpath::Path wall = wall_beyond(0);
  const auto hanging_mm = [&](std::initializer_list<std::pair<double, double>> corners) {
    wall.points.clear();
    for (const auto& [beyond, y] : corners) wall.points.push_back({from_mm(70 + beyond), from_mm(y)});
    std::vector<toolpath::Path> paths{wall};
    toolpath::mark_overhangs(paths, own, below, {}, 0.45, bare_settings().speed);
    double sum = 0;
    for (const auto& path : paths)
      if (path.role == Role::overhang_perimeter) sum += length_mm(path);
    return sum;
  };
  // Three quarters of the bead hang from 0.11 mm beyond the edge on, all of it from 0.23 mm on.
  CHECK(hanging_mm({{0, 55}, {0, 60}, {0.15, 60}, {0.15, 60.2}, {0, 60.2}, {0, 65}}) == 0);
  CHECK(hanging_mm({{0, 55},
                    {0, 60},
                    {0.15, 60},
                    {0.15, 60.2},
                    {0.3, 60.2},
                    {0.3, 60.3},
                    {0.15, 60.3},
                    {0.15, 60.5},
                    {0, 60.5},
                    {0, 65}}) > 0.5);
}

TEST_CASE("what is too thin below to have been printed carries no wall") {
  toolpath::PrintSettings s = bare_settings();
  // Between two blocks a blade, narrower than any line; a firm bridge between them carries.
  for (const double thin : {0.1, 0.4}) {
    CAPTURE(thin);
    const geom::Regions below = geom::unite({rectangle(50, 50, 60, 70), rectangle(70, 50, 80, 70),
                                             rectangle(60, 60 - thin / 2, 70, 60 + thin / 2)},
                                            {});
    const geom::Regions own{rectangle(50, 50, 80, 70)};
    toolpath::Path path = wall_beyond(0);
    path.points = {{from_mm(55), from_mm(60)}, {from_mm(75), from_mm(60)}};
    std::vector<toolpath::Path> paths{path};
    toolpath::mark_overhangs(paths, own, below, {}, 0.45, s.speed);
    double hanging = 0;
    for (const auto& p : paths)
      if (p.role == Role::overhang_perimeter) hanging += length_mm(p);
    CHECK(hanging == Approx(thin < 0.25 ? 10 : 0).margin(0.5));
  }
}

TEST_CASE("a gap line over a thread that was not printed hangs, though it is hardly wider") {
  toolpath::PrintSettings s = bare_settings();
  const auto blade = [](double width) {
    return geom::unite(
        {rectangle(50, 50, 60, 70), rectangle(70, 50, 80, 70), rectangle(60, 60, 70, 60 + width)}, {});
  };
  for (const double below : {0.06, 0.15}) {
    CAPTURE(below);
    toolpath::Path path = wall_beyond(0);
    path.role = Role::gap_fill;
    path.width_mm = 0.18;
    path.points = {{from_mm(59), from_mm(60.09)}, {from_mm(71), from_mm(60.09)}};
    std::vector<toolpath::Path> paths{path};
    toolpath::mark_overhangs(paths, blade(0.18), blade(below), {}, 0.45, s.speed);
    double hanging = 0;
    for (const auto& p : paths)
      if (p.role == Role::overhang_perimeter) hanging += length_mm(p);
    CHECK(hanging == Approx(below < 0.1 ? 10 : 0).margin(0.5));
  }
}

TEST_CASE("what rounding leaves along what was not printed carries nothing") {
  const toolpath::SpeedSettings speed = bare_settings().speed;
  for (int degrees = 3; degrees < 180; degrees += 7) {
    CAPTURE(degrees);
    const double c = std::cos(degrees * M_PI / 180), d = std::sin(degrees * M_PI / 180);
    const auto at = [&](double x, double y) {
      return geom::Point{from_mm(c * x - d * y), from_mm(d * x + c * y)};
    };
    const auto web = [&](double width) {
      geom::Region left{{at(50, 50), at(60, 50), at(60, 70), at(50, 70)}, {}};
      geom::Region right{{at(70, 50), at(80, 50), at(80, 70), at(70, 70)}, {}};
      geom::Region blade{{at(60, 60), at(70, 60.3), at(70, 60.3 + width), at(60, 60 + width)}, {}};
      return geom::unite({left, right}, {blade});
    };
    const geom::Regions bare{{{at(60.5, 60), at(68, 60.2), at(68, 60.27), at(60.5, 60.07)}, {}}};
    toolpath::Path path = wall_beyond(0);
    path.role = Role::gap_fill;
    path.width_mm = 0.18;
    path.points = {at(59, 60.06), at(71, 60.42)};
    std::vector<toolpath::Path> paths{path};
    toolpath::mark_overhangs(paths, web(0.18), web(0.06), bare, 0.45, speed);
    double hanging = 0;
    for (const auto& p : paths)
      if (p.role == Role::overhang_perimeter) hanging += length_mm(p);
    CHECK(hanging > 9.5);
  }
}

TEST_CASE("small loops keep to their speed, large ones to the wall's") {
  auto s = bare_settings();
  s.speed.perimeter = 60;
  s.speed.external_perimeter = 50;
  s.speed.small_perimeter = 12;
  s.slice.small_perimeter_length_mm = 40;
  for (const double size : {6.0, 9.0, 14.0, 30.0}) {
    const auto plan = toolpath::build(box_stack(size, size, 2), s);
    for (const auto& p : plan.layers[4].paths) {
      if (p.role != Role::perimeter && p.role != Role::external_perimeter) continue;
      const bool is_small = length_mm(p) <= 40;
      const double own = p.role == Role::perimeter ? 60 : 50;
      CHECK(toolpath::path_speed_mm_s(p, 4, s) == (is_small ? 12 : own));
    }
  }
}

TEST_CASE("what a layer left bare carries no line of the next, though the outlines hardly differ") {
  const geom::Regions own{rectangle(50, 50, 70, 50.4)}, below{rectangle(50.01, 50, 70, 50.4)};
  const auto hanging_mm = [&](const geom::Regions& bare) {
    toolpath::Path line;
    line.role = Role::gap_fill;
    line.width_mm = 0.4;
    line.points = {{from_mm(50.2), from_mm(50.2)}, {from_mm(69.8), from_mm(50.2)}};
    std::vector<toolpath::Path> paths{line};
    toolpath::mark_overhangs(paths, own, below, bare, 0.45, bare_settings().speed);
    double sum = 0;
    for (const auto& p : paths) sum += p.role == Role::overhang_perimeter ? length_mm(p) : 0;
    return sum;
  };
  CHECK(hanging_mm({}) == 0);
  CHECK(hanging_mm({rectangle(60, 49.5, 62, 51)}) == Approx(2).margin(0.5));
}

TEST_CASE("gap lines reach for ground that is near") {
  const geom::Regions own{rectangle(50, 50, 80, 52)};
  const geom::Regions below{rectangle(50, 50, 60, 52), rectangle(70, 50, 80, 52)};
  // Along x, in pieces that go on from one another, as a gap's changing width makes them.
  const auto held = [&](std::vector<double> xs, const geom::Regions& support = {}) {
    std::vector<toolpath::Path> paths;
    for (std::size_t i = 0; i + 1 < xs.size(); ++i) {
      toolpath::Path path;
      path.role = Role::gap_fill;
      path.points = {{from_mm(xs[i]), from_mm(51)}, {from_mm(xs[i + 1]), from_mm(51)}};
      paths.push_back(path);
    }
    toolpath::hold_tips(paths, own, below, support);
    std::pair<double, double> reach{1e9, -1e9};
    for (const auto& path : paths)
      for (const auto& p : path.points) {
        reach.first = std::min(reach.first, geom::to_mm(p.x));
        reach.second = std::max(reach.second, geom::to_mm(p.x));
      }
    return reach;
  };
  CHECK(held({55, 60.5}).second == Approx(60.5));  // never back
  CHECK(held({55, 64}).second == Approx(64));      // too far
  CHECK(held({55, 69.4}, {rectangle(60, 50, 70, 52)}).second == Approx(69.4));
  CHECK(held({55, 75}) == std::pair{55.0, 75.0});
  CHECK(held({55, 69.4}).second == Approx(70 + 0.2));  // goes on to ground
  const auto both = held({60.6, 65, 69.5});
  CHECK(both.first == Approx(60 - 0.2));
  CHECK(both.second == Approx(70 + 0.2));
}

TEST_CASE("gap lines go straight on along ground that lies beside them") {
  // A thin strip that runs into a block, past whose corner nothing leads to the ground beside the strip.
  const geom::Regions own =
      geom::unite(geom::Regions{rectangle(55, 50.9, 70, 51.1)}, {rectangle(70, 45, 80, 51.1)});
  const geom::Regions ground{rectangle(69, 45, 80, 50.93)};
  toolpath::Path line;
  line.role = Role::gap_fill;
  line.width_mm = 0.15;
  line.points = {{from_mm(55), from_mm(51)}, {from_mm(69.5), from_mm(51)}};
  std::vector<toolpath::Path> paths{line};
  toolpath::hold_tips(paths, own, ground, {});
  REQUIRE(paths[0].points.size() == 3);
  CHECK(geom::to_mm(paths[0].points.back().x) == Approx(69.5 + 0.05 + 0.2));
  CHECK(paths[0].points.back().y == from_mm(51));
}

TEST_CASE("a gap line that has no room as far as ground goes on to it narrower") {
  const geom::Regions own =
      geom::unite(geom::Regions{rectangle(50, 50, 69.6, 52)}, {rectangle(69.6, 50.8, 80, 51.3)});
  const geom::Regions ground{rectangle(50, 50, 60, 52), rectangle(70, 50, 80, 52)};
  toolpath::Path line;
  line.role = Role::gap_fill;
  line.width_mm = 0.8;
  line.area_mm2 = 0.15;
  // Its last step says little about where it leads.
  line.points = {{from_mm(55), from_mm(51)}, {from_mm(68.95), from_mm(51)}, {from_mm(69), from_mm(51.1)}};
  for (const bool turned : {false, true}) {
    toolpath::Path one = line;
    if (turned) std::reverse(one.points.begin(), one.points.end());
    std::vector<toolpath::Path> paths{one};
    toolpath::hold_tips(paths, own, ground, {});
    REQUIRE(paths.size() == 2);
    const toolpath::Path& lead = paths[turned ? 0 : 1];
    CHECK(paths[0].points.back() == paths[1].points.front());
    CHECK(lead.width_mm == Approx(0.5).margin(0.02));
    CHECK(lead.area_mm2 < line.area_mm2);
    CHECK(geom::to_mm((turned ? lead.points.front() : lead.points.back()).x) == Approx(70.2).margin(0.02));
  }
}

TEST_CASE("gap lines go on past what is too thin below to have been printed, and aside to ground close by") {
  const geom::Regions own{rectangle(50, 50, 80, 52)};
  const auto end_of = [&](double x, const geom::Regions& below) {
    toolpath::Path line;
    line.role = Role::gap_fill;
    line.width_mm = 0.2;
    line.points = {{from_mm(55), from_mm(51)}, {from_mm(x), from_mm(51)}};
    std::vector<toolpath::Path> paths{line};
    toolpath::hold_tips(paths, own, below, {});
    const geom::Point& end = paths[0].points.back();
    return std::pair(geom::to_mm(end.x), geom::to_mm(end.y));
  };
  const auto with = [](const geom::Region& more) {
    return geom::unite(geom::Regions{rectangle(50, 50, 60, 52)}, {more});
  };
  const geom::Regions spiked = geom::unite(with(rectangle(70, 50, 80, 52)), {rectangle(69, 50.9, 70, 51.1)});
  CHECK(end_of(69.4, spiked).first == Approx(70 + 0.2).margin(0.01));
  const auto aside = end_of(69.5, with(rectangle(69, 50, 80, 50.85)));
  CHECK(aside.first == Approx(69.5));
  CHECK(aside.second == Approx(50.85 - 0.2));
  CHECK(end_of(69.5, with(rectangle(69, 50, 80, 50.7))).second == Approx(51));  // further off
}

TEST_CASE("a loop around a hole that hangs all round begins where it hangs least") {
  const toolpath::SpeedSettings speed = bare_settings().speed;
  // The hole below is round and larger, the loop a polygon: its corners come nearest to what is below.
  const auto with_hole = [](double radius, int sides) {
    geom::Region r = rectangle(50, 50, 70, 70);
    geom::Ring hole = geom::make_circle({from_mm(60), from_mm(60)}, from_mm(radius), sides);
    geom::reverse(hole);
    r.holes.push_back(hole);
    return geom::Regions{r};
  };
  const geom::Regions below = with_hole(3.18, 96), own = with_hole(2.775, 6);
  toolpath::Path loop;
  loop.role = Role::external_perimeter;
  loop.width_mm = 0.45;
  loop.area_mm2 = 0.08;
  loop.closed = true;
  for (const double turned : {0.3, 0.5, 0.7}) {  // the seam, from corner to corner
    loop.points = geom::make_circle({from_mm(60), from_mm(60)}, from_mm(3.0), 6);
    const geom::Point a = loop.points[0], b = loop.points[1];
    loop.points.erase(loop.points.begin());
    loop.points.insert(loop.points.begin(), {a.x + std::llround(turned * static_cast<double>(b.x - a.x)),
                                             a.y + std::llround(turned * static_cast<double>(b.y - a.y))});
    loop.points.push_back(a);
    std::vector<toolpath::Path> paths{loop};
    toolpath::mark_overhangs(paths, own, below, {}, 0.45, speed);
    REQUIRE(!paths.empty());
    const geom::Point begin = paths.front().points.front();
    CAPTURE(turned);
    // In a corner itself, not where the bead begins to hang.
    CHECK(geom::distance(begin, {from_mm(60), from_mm(60)}) / geom::kNmPerMm > 2.99);
    double length = 0;
    for (const auto& path : paths) length += length_mm(path);
    CHECK(length == Approx(6 * 3.0).epsilon(1e-4));
  }
}

TEST_CASE("a wall over what the layer below left bare hangs") {
  const toolpath::SpeedSettings speed;
  const geom::Regions below{rectangle(50, 50, 80, 80)}, own{rectangle(50, 50, 81, 80)};
  const auto hanging_mm = [&](const geom::Regions& bare) {
    std::vector<toolpath::Path> paths{wall_beyond(9.9)};
    toolpath::mark_overhangs(paths, own, below, bare, 0.45, speed);
    double out = 0;
    for (const toolpath::Path& p : paths)
      if (p.role == Role::overhang_perimeter) out += geom::length(p.points) / geom::kNmPerMm;
    return out;
  };
  CHECK(hanging_mm({}) == 0);
  CHECK(hanging_mm({rectangle(79, 58, 80, 62)}) == Approx(3.8).margin(0.1));
}

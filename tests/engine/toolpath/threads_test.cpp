#include "engine/toolpath/overhang/threads.h"

#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Path;
using toolpath::Role;

namespace {

Path thread(double x0, double x1, double width_mm = 0.2) {
  Path out;
  out.role = Role::gap_fill;
  out.width_mm = width_mm;
  out.points = {{from_mm(x0), from_mm(5)}, {from_mm(x1), from_mm(5)}};
  return out;
}

const geom::Regions kGround{rectangle(0, 0, 10, 10)};
constexpr double kWidestMm = 0.34;

/// How far material reaches in x, mm.
double reach_mm(const std::vector<Path>& paths) {
  double out = 0;
  for (const Path& p : paths)
    for (const geom::Point& q : p.points) out = std::max(out, geom::to_mm(q.x));
  return out;
}

/// A block with a fin 0.25 mm thin on its side, whose lower edge juts out level at 5 mm.
slice::LayerStack fin_stack() {
  return stack_of(8, 0.2, [](double z) {
    geom::Regions out{rectangle(50, 50, 60, 60)};
    if (z > 5) out = geom::unite(out, {rectangle(60, 54, 61.5, 54.25)});
    return out;
  });
}

}  // namespace

TEST_CASE("a thread over air is cut back to a tip beyond what holds it") {
  for (const bool turned : {false, true}) {
    std::vector<Path> paths{turned ? thread(13, 5) : thread(5, 13)};
    CHECK(!toolpath::cut_threads(paths, kGround, kWidestMm).empty());
    REQUIRE(paths.size() == 1);
    CHECK(reach_mm(paths) == Approx(10.3).margin(0.11));
  }
  std::vector<Path> short_tip{thread(5, 10.3)};
  CHECK(toolpath::cut_threads(short_tip, kGround, kWidestMm).empty());
  CHECK(reach_mm(short_tip) == Approx(10.3));
}

TEST_CASE("threads in pieces are cut piece by piece, what hangs between two held ends stays") {
  std::vector<Path> paths{thread(5, 9), thread(9, 10.1, 0.22), thread(10.1, 11, 0.25), thread(11, 12, 0.2)};
  toolpath::cut_threads(paths, kGround, kWidestMm);
  CHECK(reach_mm(paths) < 10.5);
  const geom::Regions two{rectangle(0, 0, 10, 10), rectangle(14, 0, 20, 10)};
  std::vector<Path> across{thread(5, 11), thread(11, 13), thread(13, 16)};
  CHECK(toolpath::cut_threads(across, two, kWidestMm).empty());
  CHECK(across.size() == 3);
}

TEST_CASE("what is wider than asked for stays, whatever holds it") {
  std::vector<Path> paths{thread(5, 13, 0.4)};
  CHECK(toolpath::cut_threads(paths, kGround, kWidestMm).empty());
  CHECK(reach_mm(paths) == Approx(13));
}

TEST_CASE("short stubs as wide as a line begin no place that is held; with support they are left out") {
  // A strip 0.6 mm wide that juts out by 1 mm, above a foot that leaves support from the plate no room.
  const auto stack = stack_of(8, 0.2, [](double z) {
    geom::Regions out{rectangle(50, 50, z < 3 ? 65 : 60, 60)};
    if (z > 5) out = geom::unite(out, {rectangle(60, 54, 61, 54.6)});
    return out;
  });
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  const auto reach = [&](toolpath::SupportMode mode, std::size_t i) {
    s.slice.support = mode;
    double out = 60;
    const auto plan = toolpath::build(stack, s);
    for (const Path& p : plan.layers[i].paths)
      if (p.role == Role::gap_fill || p.role == Role::overhang_perimeter)
        for (const geom::Point& q : p.points) out = std::max(out, geom::to_mm(q.x));
    return out - 60;
  };
  CHECK(reach(toolpath::SupportMode::none, 25) > 0.6);
  CHECK(reach(toolpath::SupportMode::plate, 25) < 0.55);
  CHECK(reach(toolpath::SupportMode::plate, 30) > 0.6);
}

TEST_CASE("a fin too thin for a line grows out over air tip by tip, and is whole a few layers on") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  s.slice.support = toolpath::SupportMode::none;
  const auto plan = toolpath::build(fin_stack(), s);
  const auto fin_mm = [&](std::size_t i) {
    double out = 60;
    for (const Path& p : plan.layers[i].paths)
      if (p.role == Role::gap_fill)
        for (const geom::Point& q : p.points) out = std::max(out, geom::to_mm(q.x));
    return out - 60;
  };

  CHECK(fin_mm(25) < 0.7);
  CHECK(fin_mm(35) > 1.2);
  for (std::size_t i = 26; i < 36; ++i) CHECK(fin_mm(i) <= fin_mm(i - 1) + 0.65);
}

TEST_CASE("what was not printed further down holds no thread across a gap") {
  // A blade too thin for a line, a layer without it, and a fin right above.
  const auto stack = stack_of(8, 0.2, [](double z) {
    geom::Regions out{rectangle(50, 50, 60, 60)};
    if (z > 4.8 && z < 5) out = geom::unite(out, {rectangle(60, 54.1, 66, 54.15)});
    if (z > 5.2) out = geom::unite(out, {rectangle(60, 54, 66, 54.25)});
    return out;
  });
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  s.slice.support = toolpath::SupportMode::none;
  const auto plan = toolpath::build(stack, s);
  REQUIRE(stack[25].regions.front() != stack[26].regions.front());
  double reach = 60;
  for (const Path& p : plan.layers[26].paths)
    if (p.role == Role::gap_fill || p.role == Role::overhang_perimeter)
      for (const geom::Point& q : p.points) reach = std::max(reach, geom::to_mm(q.x));
  CHECK(reach > 60);
  CHECK(reach < 60.7);
}

TEST_CASE("of a line that hangs whole stays a tip in its middle; a shorter one stays") {
  std::vector<Path> paths{thread(12, 14, 0.2), thread(16, 16.35, 0.2)};
  CHECK(!toolpath::cut_threads(paths, kGround, kWidestMm).empty());
  REQUIRE(paths.size() == 2);
  CHECK(geom::to_mm(paths[0].points.front().x) == Approx(12.85).margin(0.11));
  CHECK(geom::to_mm(paths[0].points.back().x) == Approx(13.15).margin(0.11));
  CHECK(geom::length(paths[1].points) == Approx(0.35 * geom::kNmPerMm).margin(2));
}

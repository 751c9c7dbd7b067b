#include "engine/orient/slabs.h"
#include "engine/report/markup.h"
#include "engine/report/part_picture.h"
#include "engine/report/ranking.h"
#include "engine/report/raster.h"
#include "engine/report/scan.h"
#include "engine/report/void_columns.h"
#include "tests/support/meshes.h"

#include <array>
#include <cmath>
#include <numeric>
#include <set>

#include <catch2/catch.hpp>

using namespace voidpath;
using geom::Vec3;

namespace {

report::Standing standing(const mesh::TriangleMesh& m, const Vec3& up = Vec3::UnitZ()) {
  return {mesh::turned(m, up), 45};
}

double empty_volume(const report::Standing& s) {
  const auto area = s.columns.area_by_height(s.box.max.z(), 50);
  return std::accumulate(area.begin(), area.end(), 0.0) * s.box.max.z() / 50;
}

}  // namespace

TEST_CASE("triangles that share edges cover each cell once") {
  // A fan around a point that is itself a cell's middle, its spokes through other middles.
  constexpr int kSize = 40;
  std::array<int, kSize * kSize> hits{};
  const report::Corner middle{20.5, 20.5, 1};
  const std::array<report::Corner, 8> rim = {{{38.5, 20.5, 0},
                                              {33.5, 33.5, 0},
                                              {20.5, 38.5, 0},
                                              {7.5, 33.5, 0},
                                              {2.5, 20.5, 0},
                                              {7.5, 7.5, 0},
                                              {20.5, 2.5, 0},
                                              {33.5, 7.5, 0}}};
  for (std::size_t k = 0; k < rim.size(); ++k)
    report::scan({middle, rim[k], rim[(k + 1) % rim.size()]}, kSize, kSize, [&](int i, int j, double value) {
      ++hits[static_cast<std::size_t>(j * kSize + i)];
      CHECK((value >= 0 && value <= 1));
    });
  double area = 0;
  for (const int h : hits) {
    REQUIRE(h <= 1);
    area += h;
  }
  double exact = 0;
  for (std::size_t k = 0; k < rim.size(); ++k) {
    const auto& a = rim[k];
    const auto& b = rim[(k + 1) % rim.size()];
    exact += 0.5 * (a.x * b.y - b.x * a.y);
  }
  CHECK(area == Approx(exact).epsilon(0.03));
  CHECK(hits[20 * kSize + 20] == 1);
}

TEST_CASE("empty space under a part agrees with the criterion") {
  const mesh::TriangleMesh table = test::table(60, 40, 50, 4, 6);
  // Under the plate between the legs: closed form.
  CHECK(empty_volume(standing(table)) == Approx((60 * 40 - 4 * 6 * 6) * 46.0).epsilon(0.02));
  CHECK(standing(table).columns.support_mm3() == Approx((60 * 40 - 4 * 6 * 6) * 46.0).epsilon(0.02));
  CHECK(empty_volume(standing(table, -Vec3::UnitZ())) == 0);
  const mesh::TriangleMesh ball = test::sphere(20);
  for (const Vec3& d : {Vec3(0.3, -0.2, 0.9), Vec3(-1, 0.4, 0.1)}) {
    const auto exact = orient::evaluate(table, {d.normalized()}, {});
    CHECK(empty_volume(standing(table, d.normalized())) == Approx(exact[0].trapped_mm3).epsilon(0.03));
    const auto of_ball = orient::evaluate(ball, {d.normalized()}, {});
    CHECK(empty_volume(standing(ball, d.normalized())) == Approx(of_ball[0].trapped_mm3).epsilon(0.03));
  }
}

TEST_CASE("only what leans out further than the limit is an overhang") {
  const auto ball = standing(test::sphere(20, 64, 128));
  const auto overhang = report::find_overhangs(ball.mesh, 45);
  double area = 0;
  for (std::size_t t = 0; t < overhang.size(); ++t) {
    const auto& [a, b, c] = ball.mesh.triangles[t];
    const auto& v = ball.mesh.vertices;
    if (overhang[t]) area += 0.5 * (v[b] - v[a]).cross(v[c] - v[a]).norm();
  }
  // The cap below 45°, less the little that lies within 0.2 mm of the plate.
  const double cap = 2 * M_PI * 20 * 20 * (1 - std::sqrt(0.5)) - 2 * M_PI * 20 * 0.2;
  CHECK(area == Approx(cap).epsilon(0.08));
  const auto cube = standing(test::cube(20));
  for (const bool o : report::find_overhangs(cube.mesh, 45)) CHECK_FALSE(o);
}

TEST_CASE("a lip narrower than two beads needs no support, a ledge does") {
  const auto with_ledge = [](double reach) {
    const auto m =
        test::joined(test::box(20, 20, 10), test::moved(test::box(20 + 2 * reach, 20, 2), 0, 0, 8));
    return standing(m).columns.support_mm3();
  };
  CHECK(with_ledge(0.3) == 0);
  CHECK(with_ledge(3) == Approx(2 * 3 * 20 * 8.0).epsilon(0.05));
}

TEST_CASE("a painting shows the part, its overhangs and what supports them") {
  const auto inks = [](const report::Standing& s) {
    report::Window w{-100, 100, 2, 400, 400};
    const auto painting = report::paint(s, {}, w);
    std::map<report::Ink, std::size_t> out;
    for (const auto code : painting.pixels) ++out[static_cast<report::Ink>(code / report::kShades)];
    return out;
  };
  const mesh::TriangleMesh table = test::table(60, 40, 50, 4, 6);
  auto upright = inks(standing(table));
  CHECK(upright[report::Ink::part] > 1000);
  CHECK(upright[report::Ink::support] + upright[report::Ink::part_behind_support] > 1000);
  auto upside_down = inks(standing(table, -Vec3::UnitZ()));
  CHECK(upside_down[report::Ink::part] > 1000);
  CHECK(upside_down[report::Ink::support] + upside_down[report::Ink::part_behind_support] == 0);
  CHECK(upside_down[report::Ink::overhang] == 0);
  CHECK(inks(standing(test::sphere(20)))[report::Ink::overhang] > 50);
}

TEST_CASE("pictures to be compared share one scale") {
  const auto tall = standing(test::box(10, 10, 100));
  const auto flat = standing(test::box(10, 10, 100), Vec3::UnitX());
  const auto frame = report::common_frame(tall, flat);
  CHECK(frame.px_per_mm == report::common_frame(flat, tall).px_per_mm);
  CHECK(frame.height >= 100 * frame.px_per_mm * std::cos(0.42));
  CHECK(report::part_picture(tall, frame, "a").find("100.0 mm") != std::string::npos);
  CHECK(report::part_picture(flat, frame, "b").find("10.0 mm") != std::string::npos);
}

TEST_CASE("slabs average to the criteria of the search") {
  const mesh::TriangleMesh comb = test::comb(5, 6, 9, 30, 4);
  const mesh::TriangleMesh ball = test::sphere(20);
  const std::vector<Vec3> directions = {Vec3::UnitZ(),
                                        -Vec3::UnitZ(),
                                        Vec3::UnitX(),
                                        -Vec3::UnitY(),
                                        Vec3(0.2, -0.5, 0.7).normalized(),
                                        Vec3(-0.6, -0.5, -0.3).normalized()};
  for (const auto* m : {&comb, &ball})
    for (const auto rule : {orient::CriticalRule::normals, orient::CriticalRule::morse}) {
      orient::SearchOptions options;
      options.critical = rule;
      const auto slabs = orient::slabs_of(*m, directions, options);
      const auto criteria = orient::evaluate(*m, directions, options);
      REQUIRE(slabs.size() == directions.size());
      for (std::size_t i = 0; i < directions.size(); ++i) {
        double c = 0, d = 0, height = 0;
        for (const auto& s : slabs[i]) {
          CHECK(s.bottom_mm == Approx(height).margin(1e-6));
          height = s.top_mm;
          c += (s.top_mm - s.bottom_mm) * s.contours;
          d += (s.top_mm - s.bottom_mm) * s.void_mm;
        }
        CHECK(height == Approx(criteria[i].height_mm));
        CHECK(c / height == Approx(criteria[i].contours));
        CHECK(d / height == Approx(criteria[i].void_mm).margin(1e-9));
      }
    }
  // Four posts' width apart: the lower slab is the base plate.
  const auto standing_up = orient::slabs_of(comb, {Vec3::UnitZ()}, {}).front();
  REQUIRE(standing_up.size() == 2);
  CHECK(standing_up[0].top_mm == Approx(4));
  CHECK(standing_up[0].contours == 1);
  CHECK(standing_up[1].contours == 5);
}

TEST_CASE("the ranking names each candidate once, the chosen one first") {
  orient::SearchOptions options;
  options.subdivisions = 2;
  auto choice = orient::search(test::table(60, 40, 50, 4, 6), options);
  choice.baselines = {{"as-delivered", choice.as_delivered}, {"thesis", choice.chosen}, {"axis +x", 3}};
  const auto named = report::ranking(choice);
  REQUIRE(named.size() >= 3);
  CHECK(named[0].candidate == choice.chosen);
  CHECK(named[1].candidate == choice.as_delivered);
  CHECK(named[0].name == "chosen · best by four criteria");
  std::set<std::size_t> seen;
  std::set<std::string> marks;
  for (const auto& n : named) {
    CHECK(seen.insert(n.candidate).second);
    CHECK(marks.insert(n.mark).second);
  }
  for (const std::size_t a : report::runners_up(choice, 10))
    for (const std::size_t b : report::runners_up(choice, 10))
      if (a != b) CHECK(choice.candidates[a].direction.dot(choice.candidates[b].direction) < 0.9);
}

TEST_CASE("numbers and texts of pages") {
  CHECK(report::fixed(-0.001, 2) == "0.00");
  CHECK(report::fixed(-1.25, 1).substr(0, 2) == "-1");
  CHECK(report::duration(59.6) == "1 min 00 s");
  CHECK(report::duration(12.3) == "12 s");
  CHECK(report::duration(3725) == "1 h 02 min");
  CHECK(report::duration(3599.8) == "1 h 00 min");
  CHECK(report::change(50, 100) == "50 % less");
  CHECK(report::change(100, 100) == "the same");
  CHECK(report::change(103.4, 100) == "3.4 % more");
  CHECK(report::change(5, 0).empty());
  CHECK(report::escaped("a<b>&\"'") == "a&lt;b&gt;&amp;&quot;&#39;");
  CHECK(report::escaped("\xC3\xA4\xC0\xAF") == "\xC3\xA4\xEF\xBF\xBD\xEF\xBF\xBD");
  CHECK(report::hex({0, 127.6, 300}) == "#0080ff");
}

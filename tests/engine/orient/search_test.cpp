#include "engine/orient/search.h"

#include "engine/orient/feasible.h"
#include "engine/orient/score.h"
#include "tests/support/meshes.h"

#include <cmath>
#include <iterator>
#include <numbers>
#include <string>
#include <utility>

#include <catch2/catch.hpp>

namespace voidpath::test {

using geom::Vec3;
using orient::Candidate;
using orient::Choice;
using orient::Method;
using orient::Origin;
using orient::SearchOptions;

namespace {

SearchOptions with(Method method, int subdivisions = 2) {
  SearchOptions o;
  o.method = method;
  o.subdivisions = subdivisions;
  return o;
}

}  // namespace

TEST_CASE("one thread and eight give the same bits") {
  const mesh::TriangleMesh m = joined(comb(5, 3, 2.5, 15, 5), moved(sphere(6, 14, 20), 4, 12, 2));
  run::Context one;
  one.threads = 1;
  run::Context eight;
  eight.threads = 8;
  for (const Method method : {Method::thesis, Method::toolpath}) {
    const Choice a = orient::search(m, with(method), one);
    const Choice b = orient::search(m, with(method), eight);
    REQUIRE(a.candidates.size() == b.candidates.size());
    CHECK(a.chosen == b.chosen);
    CHECK(a.ties == b.ties);
    for (std::size_t i = 0; i < a.candidates.size(); ++i) {
      const Candidate& p = a.candidates[i];
      const Candidate& q = b.candidates[i];
      REQUIRE(p.direction == q.direction);
      REQUIRE(p.criteria.height_mm == q.criteria.height_mm);
      REQUIRE(p.criteria.trapped_mm3 == q.criteria.trapped_mm3);
      REQUIRE(p.criteria.contours == q.criteria.contours);
      REQUIRE(p.criteria.void_mm == q.criteria.void_mm);
      REQUIRE(p.score == q.score);
    }
  }
}

TEST_CASE("a direction's criteria do not depend on who else is looked at") {
  const mesh::TriangleMesh m = table(40, 30, 20, 4, 5);
  const Choice c = orient::search(m, with(Method::thesis, 1));
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{17}, std::size_t{40}}) {
    const auto alone = orient::evaluate(m, {c.candidates[i].direction}, with(Method::thesis)).at(0);
    CHECK(alone.trapped_mm3 == c.candidates[i].criteria.trapped_mm3);
    CHECK(alone.void_mm == c.candidates[i].criteria.void_mm);
  }
}

TEST_CASE("the published method looks at the sampled directions and the axes alone") {
  const Choice c = orient::search(box(30, 20, 10), with(Method::thesis, 3));
  CHECK(c.candidates.size() == 1286);
  CHECK(c.candidates[c.as_delivered].direction == Vec3::UnitZ());
  // Flat on its largest face, either way up.
  CHECK(c.chosen == c.as_delivered);
  CHECK(c.ties.size() == 2);
  for (const Candidate& k : c.candidates) CHECK(k.origin != Origin::resting_face);
}

TEST_CASE("scores scale each criterion over the candidates") {
  std::vector<Candidate> c(3);
  c[0].criteria = {10, 500, 2, 7};
  c[1].criteria = {20, 100, 2, 3};
  c[2].criteria = {30, 300, 2, 5};
  orient::score(c, orient::Weights{0.4, 0.3, 0.2, 0.1});
  CHECK(c[0].score == Approx(0.4 * 0 + 0.3 * 1 + 0.2 * 1));
  CHECK(c[1].score == Approx(0.4 * 0.5 + 0.3 * 0 + 0.2 * 0));
  CHECK(c[2].score == Approx(0.4 * 1 + 0.3 * 0.5 + 0.2 * 0.5));
}

TEST_CASE("the three-criteria method has its own weights unless told others") {
  CHECK(orient::search(cube(10), with(Method::ahsan, 0)).weights.h == orient::kAhsanWeights.h);
  SearchOptions o = with(Method::ahsan, 0);
  o.weights = {1, 0, 0, 0};
  CHECK(orient::search(cube(10), o).weights.h == 1);
}

TEST_CASE("a turned box is laid on its face exactly") {
  const geom::Quaternion q = geom::Quaternion(0.3, 0.8, -0.2, 0.5).normalized();
  const mesh::TriangleMesh m = mesh::rotated(box(40, 30, 8), q);
  const Choice c = orient::search(m, with(Method::toolpath));
  const Candidate& best = c.candidates[c.chosen];
  CHECK(best.origin == Origin::resting_face);
  CHECK(best.printable);
  CHECK(best.criteria.height_mm == Approx(8).epsilon(1e-9));
  CHECK(best.criteria.trapped_mm3 == Approx(0).margin(1e-3));
  CHECK_FALSE(c.candidates[c.as_delivered].printable);  // stands on a corner
  CHECK(c.why.find("8 mm instead of") != std::string::npos);
}

TEST_CASE("as delivered is one candidate, evaluated") {
  const Choice c = orient::search(table(40, 30, 20, 4, 5), with(Method::as_delivered));
  REQUIRE(c.candidates.size() == 1);
  CHECK(c.candidates[0].origin == Origin::as_delivered);
  CHECK(c.candidates[0].criteria.contours == Approx(3.4));
  CHECK(c.candidates[0].printable);
}

TEST_CASE("how a part stands as delivered is told the same without the criteria that nobody asks for") {
  const auto inside_out = [](mesh::TriangleMesh m) {
    for (auto& t : m.triangles) std::swap(t[1], t[2]);
    return m;
  };
  const mesh::TriangleMesh turned = mesh::turned(box(20, 20, 20), Vec3(1, 1, 1).normalized());
  const mesh::TriangleMesh parts[] = {
      table(40, 30, 20, 4, 5),                                                 // stands
      turned,                                                                  // on a corner
      sphere(6, 14, 20),                                                       // on a point
      inside_out(box(20, 20, 20)),                                             // facets look inwards
      joined(box(20, 20, 4), inside_out(moved(box(20, 20, 4), 60, 0, 0))),     // one of two does
      joined(box(20, 20, 20), inside_out(moved(box(10, 10, 10), 5, 5, 5))),    // a cavity
      joined(box(20, 20, 20), moved(inside_out(box(20, 20, 20)), 10, 10, 0)),  // they run through one another
      box(400, 20, 20),                                                        // too large for the bed
  };
  std::size_t standing = 0;
  for (const mesh::TriangleMesh& m : parts) {
    SearchOptions o = with(Method::as_delivered);
    std::string all, quick;
    const auto tell = [&](std::string& out) {
      try {
        const Choice c = orient::search(m, o);
        out = std::to_string(c.candidates[0].criteria.height_mm) + " " +
              std::to_string(c.candidates[0].printable) + " " + c.candidates[0].why + c.why;
        standing += c.candidates[0].printable ? 1u : 0u;
      } catch (const orient::NothingFits& e) {
        out = e.what();
      }
    };
    tell(all);
    o.all_criteria = false;
    tell(quick);
    CHECK(all == quick);
  }
  CHECK(standing >= 4);
  CHECK(standing < 2 * std::size(parts));
}

TEST_CASE("what fits nowhere is refused with its size") {
  SearchOptions o = with(Method::toolpath, 1);
  CHECK_THROWS_WITH(orient::search(cube(300), o),
                    Catch::Contains("300 × 300 × 300 mm") && Catch::Contains("220 × 220 × 250"));
  CHECK_THROWS_AS(orient::search(cube(300), o), orient::NothingFits);
  // The published method does not ask.
  o.method = Method::thesis;
  const Choice c = orient::search(cube(300), o);
  CHECK_FALSE(c.candidates[c.chosen].printable);
}

TEST_CASE("a part as long as the bed's diagonal fits when turned") {
  // 250 long on a free bed of 216 × 216: only crosswise. Upright it is too tall for a printer of 240 mm.
  SearchOptions o = with(Method::toolpath, 1);
  o.limits.volume_mm = {220, 220, 240};
  const mesh::TriangleMesh bar = box(250, 20, 20);
  const Choice c = orient::search(bar, o);
  CHECK(c.candidates[c.as_delivered].printable);
  const auto turn = orient::bed_turn(bar, Vec3::UnitZ(), o.limits);
  REQUIRE(turn);
  const double s = std::abs(std::sin(*turn));
  const double k = std::abs(std::cos(*turn));
  CHECK(250 * k + 20 * s <= 216.001);
  CHECK(250 * s + 20 * k <= 216.001);
  CHECK_FALSE(orient::bed_turn(box(300, 20, 20), Vec3::UnitZ(), o.limits));
  CHECK(*orient::bed_turn(box(200, 200, 20), Vec3::UnitZ(), o.limits) == 0);
}

TEST_CASE("what cannot stand is told so") {
  SearchOptions o = with(Method::thesis, 1);
  // A ball touches in a cap of depth 0.2: of radius √(2·10·0.2), 12.6 mm², more than 2 % of 20 × 20.
  Choice c = orient::search(sphere(10, 64, 128), o);
  CHECK(c.candidates[c.as_delivered].printable);
  o.limits.min_contact_share = 0.05;
  c = orient::search(sphere(10, 64, 128), o);
  CHECK_THAT(c.candidates[c.as_delivered].why, Catch::Contains("too little to stand on"));
  // A plate hung out over a foot at its end: the centre of mass is not over the foot.
  const mesh::TriangleMesh crane = joined(box(6, 20, 20), moved(box(60, 20, 5), 0, 0, 19.9));
  c = orient::search(crane, o);
  CHECK_THAT(c.candidates[c.as_delivered].why, Catch::Contains("would tip over"));
}

TEST_CASE("a search stops when asked") {
  std::stop_source stop;
  stop.request_stop();
  run::Context ctx;
  ctx.stop = stop.get_token();
  CHECK_THROWS_AS(orient::search(cube(10), with(Method::thesis), ctx), run::Stopped);
}

TEST_CASE("methods have names") {
  for (const Method m : {Method::toolpath, Method::thesis, Method::ahsan, Method::as_delivered})
    CHECK(orient::method_from(orient::to_string(m)) == m);
  CHECK_FALSE(orient::method_from("fastest"));
}

}  // namespace voidpath::test

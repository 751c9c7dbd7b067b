#include "engine/evaluate/compare.h"

#include "engine/evaluate/page.h"
#include "engine/evaluate/summary.h"
#include "engine/evaluate/table.h"
#include "tests/support/meshes.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using evaluate::Row;

namespace {

evaluate::CompareOptions quick_options() {
  evaluate::CompareOptions o;
  o.prepare.orient.subdivisions = 1;
  o.prepare.print.slice.layer_height_mm = 0.4;
  o.prepare.print.slice.first_layer_height_mm = 0.4;
  o.prepare.max_extra = 2;
  return o;
}

Row row(const std::string& model, const std::string& method, double seconds) {
  Row r;
  r.model = model;
  r.method = method;
  r.triangles = 12;
  r.direction = geom::Vec3(0.6, 0, 0.8);
  r.criteria = {10, 20.5, 1, 0.1};
  r.predicted_s = seconds;
  r.ratio = 1.0;
  return r;
}

}  // namespace

TEST_CASE("no method chooses a quicker direction than the default one") {
  const auto o = quick_options();
  for (const auto& mesh :
       {test::table(30, 20, 24, 3, 4), test::cup(18, 14, 20, 2, 2), test::box(8, 12, 30)}) {
    const auto rows = evaluate::compare("part", mesh, o);
    REQUIRE(rows.size() == o.methods.size());
    const Row* best = evaluate::find_row(rows, "part", "toolpath");
    REQUIRE(best);
    REQUIRE(best->predicted_s);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Row& r = rows[i];
      CAPTURE(r.method);
      CHECK(r.method == o.methods[i]);
      CHECK(r.triangles == mesh.triangles.size());
      CHECK(r.direction.norm() == Approx(1));
      if (!r.predicted_s) {
        CHECK_FALSE(r.why.empty());
        continue;
      }
      CHECK(*best->predicted_s <= *r.predicted_s);
      CHECK(r.why.empty());
    }
    const Row* delivered = evaluate::find_row(rows, "part", "as-delivered");
    CHECK(delivered->direction == geom::Vec3::UnitZ());
    CHECK(delivered->ratio == 1.0);
    CHECK(best->ratio == *best->predicted_s / *delivered->predicted_s);
  }
}

TEST_CASE("each method chooses what its name says") {
  auto o = quick_options();
  const auto rows = evaluate::compare("table", test::table(30, 20, 24, 3, 4), o);
  CHECK(evaluate::find_row(rows, "table", "tweaker")->direction == -geom::Vec3::UnitZ());
  for (const Row& r : rows)
    CHECK(evaluate::find_row(rows, "table", "lowest")->criteria.height_mm <= r.criteria.height_mm);
  const Row* axes = evaluate::find_row(rows, "table", "axes");
  CHECK(axes->direction.cwiseAbs().maxCoeff() == 1.0);
  CHECK(*axes->predicted_s <= *evaluate::find_row(rows, "table", "as-delivered")->predicted_s);
}

TEST_CASE("the oracle is the quickest of all, and no help to the default method") {
  auto o = quick_options();
  o.prepare.max_extra = 0;
  const auto mesh = test::cup(18, 14, 20, 2, 2);
  o.methods = {"toolpath"};
  const auto alone = evaluate::compare("cup", mesh, o);
  o.methods = {"oracle", "toolpath"};
  const auto rows = evaluate::compare("cup", mesh, o);
  CHECK(rows[0].method == "oracle");
  CHECK(*rows[0].predicted_s <= *rows[1].predicted_s);
  CHECK(rows[1].direction == alone[0].direction);
  CHECK(rows[1].predicted_s == alone[0].predicted_s);
}

TEST_CASE("the rows are the same on one thread and on many") {
  const auto o = quick_options();
  run::Context one, many;
  one.threads = 1;
  many.threads = 4;
  const auto mesh = test::comb(4, 4, 4, 16, 3);
  CHECK(evaluate::to_csv(evaluate::compare("comb", mesh, o, one)) ==
        evaluate::to_csv(evaluate::compare("comb", mesh, o, many)));
}

TEST_CASE("a direction that cannot be printed has a reason instead of a time") {
  auto o = quick_options();
  o.prepare.orient.limits.volume_mm = {100, 100, 25};
  o.prepare.print.machine.bed_mm = {100, 100};
  o.prepare.print.machine.height_mm = 25;
  o.methods = {"as-delivered", "toolpath"};
  const auto rows = evaluate::compare("tall", test::box(8, 12, 30), o);
  CHECK_FALSE(rows[0].predicted_s);
  CHECK(rows[0].why.find("too tall") == 0);
  CHECK(rows[1].predicted_s);
  CHECK_FALSE(rows[1].ratio);  // over nothing
}

TEST_CASE("what is written as CSV reads back the same") {
  std::vector<Row> rows = {row("a, \"b\"\nc", "thesis", 1.0 / 3), row("d", "ahsan", 1e7),
                           evaluate::failed("e.stl", "line 3: no, really")};
  rows[0].why = "x";
  rows[0].turn_rad = 0.25;
  rows[0].in_full = 3;
  rows[0].complete = false;
  rows[1].predicted_s.reset();
  rows[1].ratio.reset();
  const auto again = evaluate::from_csv(evaluate::to_csv(rows));
  REQUIRE(again.size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    CHECK(again[i].model == rows[i].model);
    CHECK(again[i].method == rows[i].method);
    CHECK(again[i].triangles == rows[i].triangles);
    CHECK(again[i].direction == rows[i].direction);
    CHECK(again[i].criteria.trapped_mm3 == rows[i].criteria.trapped_mm3);
    CHECK(again[i].predicted_s == rows[i].predicted_s);
    CHECK(again[i].ratio == rows[i].ratio);
    CHECK(again[i].why == rows[i].why);
    CHECK(again[i].turn_rad == rows[i].turn_rad);
    CHECK(again[i].in_full == rows[i].in_full);
    CHECK(again[i].complete == rows[i].complete);
  }
  CHECK_THROWS_WITH(evaluate::from_csv("header\na,b\n"), Catch::Contains("line 2"));
  CHECK_THROWS_WITH(evaluate::from_csv("header\nm,x,t,0,0,0,0,0,0,0,,,0,,0,0,0,0,1\n"),
                    Catch::Contains("'x' is not a number"));
}

TEST_CASE("shares, pairs and quantiles") {
  const auto s = evaluate::shares_of({1, 1.0005, 0.9995, 1.2, 0.5, 2, 3, 1.5});
  CHECK(s.count == 8);
  CHECK(s.equal == Approx(3 / 8.0));
  CHECK(s.above == Approx(4 / 8.0));
  CHECK(s.below == Approx(1 / 8.0));
  CHECK(evaluate::quantile({3, 1, 2}, 0.5) == 2);
  CHECK(evaluate::quantile({4, 1}, 0.25) == 1.75);
  CHECK(evaluate::quantile({4, 1}, 1) == 4);

  std::vector<Row> rows = {row("a", "ahsan", 30), row("a", "thesis", 20), row("b", "ahsan", 10),
                           evaluate::failed("c", "gone")};
  const auto pair = evaluate::compare_methods(rows, "ahsan", "thesis");
  CHECK(pair.ratios == std::vector<double>{1.5});
  CHECK(pair.models == std::vector<std::string>{"a"});
  CHECK(evaluate::models_of(rows) == std::vector<std::string>{"a", "b", "c"});
  CHECK(evaluate::summary_text(rows).find("1 models: 0 % equal, 100 % faster, 0 % slower") !=
        std::string::npos);
}

TEST_CASE("the page tells the figures, names what failed, and loads nothing") {
  std::vector<Row> rows;
  for (const auto& [model, three, four, best] :
       {std::tuple("a<b>.stl", 20.0, 10.0, 9.0), std::tuple("c.stl", 10.0, 10.0, 8.0),
        std::tuple("d.stl", 5.0, 10.0, 5.0), std::tuple("e.stl", 10.0, 10.0, 10.0)}) {
    rows.push_back(row(model, "ahsan", three));
    rows.push_back(row(model, "thesis", four));
    rows.push_back(row(model, "toolpath", best));
  }
  rows.push_back(evaluate::failed("broken.stl", "not a <model>"));
  const std::string page = evaluate::comparison_page(rows, {{"profile", "x & y"}});
  CHECK(page.find("<td>50 %</td><td>25 %</td><td>25 %</td>") != std::string::npos);
  CHECK(page.find("<td>62 %</td><td>15 %</td><td>23 %</td>") != std::string::npos);
  CHECK(page.find("broken.stl: not a &lt;model&gt;") != std::string::npos);
  CHECK(page.find("a&lt;b&gt;.stl") != std::string::npos);
  CHECK(page.find("x &amp; y") != std::string::npos);
  CHECK(page.find("<b>.stl") == std::string::npos);
  for (const char* outside : {"http:", "https:", "<script", "<link", "src=", "@import", "url("})
    CHECK(page.find(outside) == std::string::npos);
  CHECK(page.find("<svg") != std::string::npos);
  // Without any row it is still a page.
  CHECK(evaluate::comparison_page({}, {}).find("</html>") != std::string::npos);
}

#include "engine/toolpath/travel/wipe.h"

#include "engine/gcode/estimate.h"
#include "engine/toolpath/emit/emit.h"
#include "tests/engine/toolpath/shapes.h"

#include <sstream>
#include <string>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;

namespace {

toolpath::Path path_through(std::initializer_list<std::pair<double, double>> points, bool closed) {
  toolpath::Path p;
  for (const auto& [x, y] : points) p.points.push_back({from_mm(x), from_mm(y)});
  p.closed = closed;
  p.area_mm2 = 0.08;
  return p;
}

}  // namespace

TEST_CASE("wiping goes back over an open path and along a closed one, towards the next") {
  const auto open = path_through({{0, 0}, {10, 0}, {10, 2}}, false);
  const auto back = toolpath::wipe_way(open, {from_mm(50), from_mm(50)}, 5);
  CHECK(back == geom::Polyline{{from_mm(10), from_mm(2)}, {from_mm(10), 0}, {from_mm(7), 0}});
  const auto all = toolpath::wipe_way(open, {0, 0}, 50);
  CHECK(geom::length(all) / geom::kNmPerMm == Approx(12));

  const auto closed = path_through({{0, 0}, {10, 0}, {10, 10}, {0, 10}}, true);
  const auto right = toolpath::wipe_way(closed, {from_mm(50), 0}, 3);
  CHECK(right == geom::Polyline{{0, 0}, {from_mm(3), 0}});
  const auto up = toolpath::wipe_way(closed, {0, from_mm(50)}, 13);
  CHECK(up == geom::Polyline{{0, 0}, {0, from_mm(10)}, {from_mm(3), from_mm(10)}});
  CHECK(toolpath::wipe_way(closed, {0, 0}, 0).empty());
}

TEST_CASE("a wipe draws back what a retraction does, on the part, and takes no more material") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  toolpath::LayerPlan layer;
  layer.span = {0, 0.2};
  layer.outline = {rectangle(0, 0, 20, 20), rectangle(40, 0, 60, 20)};
  layer.paths = {path_through({{1, 5}, {18, 5}}, false), path_through({{45, 5}, {45.5, 5}}, false),
                 path_through({{1, 9}, {18, 9}}, false)};
  for (const bool relative : {true, false}) {
    s.machine.relative_e = relative;
    s.retract.wipe = false;
    std::ostringstream plain_text, wiped_text;
    const auto plain = toolpath::emit({{layer}}, s, "", plain_text, {});
    s.retract.wipe = true;
    const auto wiped = toolpath::emit({{layer}}, s, "", wiped_text, {});
    CHECK(wiped.filament_mm == plain.filament_mm);
    CHECK(wiped.retractions == plain.retractions);
    std::istringstream a(plain_text.str()), b(wiped_text.str());
    const auto before = gcode::estimate(a, {}), after = gcode::estimate(b, {});
    CHECK(after.retractions == before.retractions);
    CHECK(after.filament_mm == Approx(before.filament_mm).margin(1e-3));
    // Retracting on the way costs nearly nothing beyond the way itself.
    CHECK(after.predicted_s == Approx(before.predicted_s).epsilon(0.1));
    CHECK(wiped_text.str().find(";WIPE_START\n") != std::string::npos);
  }
  // 0.8 mm of filament over 17 mm of path: within what 0.8 / 35 s allows at 0.8 x 180 mm/s.
  s.machine.relative_e = true;
  std::ostringstream text;
  toolpath::emit({{layer}}, s, "", text, {});
  const std::string wipe = text.str().substr(text.str().find(";WIPE_START"));
  CHECK(wipe.rfind(";WIPE_START\nG1 X14.709 E-0.8 F8640\n;WIPE_END\n", 0) == 0);
}

#include "engine/toolpath/support/support_lines.h"

#include "tests/engine/toolpath/shapes.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

geom::Regions printed(const std::vector<toolpath::Path>& paths) {
  geom::Rings beads;
  toolpath::LayerPlan layer;
  layer.paths = paths;
  return covered(
      layer, [](const toolpath::Path&) { return true; }, 0);
}

}  // namespace

TEST_CASE("dense support misses no strip, wherever it lies and however narrow it is") {
  const toolpath::SliceSettings s;
  const toolpath::BeadSize bead = toolpath::bead_of_layer(s, 1, 0.2);
  for (int shift = 0; shift < 12; ++shift)
    for (const double width : {0.46, 0.6, 0.8, 0.95})
      for (const double length : {0.7, 12.0})
        for (const bool roof : {false, true}) {
          const double x = 40 + 0.05 * shift;
          const geom::Region strip = rectangle(x, 30, x + width, 30 + length);
          toolpath::SupportAreas areas;
          (roof ? areas.interface : areas.floor) = {strip};
          const auto paths = toolpath::support_lines(areas, 3, bead, s);
          INFO("at " << x << ", " << width << " wide, " << length << " long, roof " << roof);
          REQUIRE(!paths.empty());
          // From end to end, but for the middle of a strip that two lines leave open.
          const geom::Regions bare = geom::subtract({strip}, geom::offset(printed(paths), from_mm(0.3)));
          CHECK(geom::area(bare) < 1e-9);
        }
}

TEST_CASE("a floor for borders reaches to its own border all around") {
  const toolpath::SliceSettings s;
  const toolpath::BeadSize bead = toolpath::bead_of_layer(s, 1, 0.2);
  for (int shift = 0; shift < 12; ++shift) {
    const double x = 40 + 0.05 * shift;
    toolpath::SupportAreas areas;
    areas.floor = {rectangle(x, 30, x + 2.3, 36)};
    const auto paths = toolpath::support_lines(areas, 3, bead, s);
    const geom::Regions rim = geom::subtract(areas.floor, geom::offset(areas.floor, -from_mm(0.4)));
    CHECK(geom::area(geom::subtract(rim, geom::offset(printed(paths), from_mm(0.06)))) < 1e-9);
  }
}

TEST_CASE("dense lines reach from border to border: what lies on them ends where they do") {
  const toolpath::SliceSettings s;
  const toolpath::BeadSize bead = toolpath::bead_of_layer(s, 1, 0.2);
  for (int shift = 0; shift < 12; ++shift)
    for (const double width : {1.3, 2.6, 5.1}) {
      const double x = 40 + 0.05 * shift;
      toolpath::SupportAreas areas;
      areas.interface = {rectangle(x, 30, x + width, 36)};
      const auto box = geom::bounds(printed(toolpath::support_lines(areas, 3, bead, s)));
      INFO("at " << x << ", " << width << " wide");
      REQUIRE(box.has_value());
      CHECK(geom::to_mm(box->min.x) == Approx(x).margin(0.02));
      CHECK(geom::to_mm(box->max.x) == Approx(x + width).margin(0.02));
    }
}

TEST_CASE("a corner that just reaches a sparse line gets no dot there") {
  const toolpath::SliceSettings s;
  const toolpath::BeadSize bead = toolpath::bead_of_layer(s, 1, 0.2);
  std::size_t lines = 0;
  for (int shift = 0; shift < 300; ++shift) {
    const double y = 40 + 0.01 * shift;
    toolpath::SupportAreas areas;  // less high than lines are apart
    areas.sparse = {
        {{{from_mm(40), from_mm(y)}, {from_mm(42), from_mm(y + 2)}, {from_mm(38), from_mm(y + 2)}}, {}}};
    CAPTURE(y);
    for (const auto& path : toolpath::support_lines(areas, 3, bead, s)) {
      ++lines;
      CHECK(length_mm(path) > 0.2);
    }
  }
  CHECK(lines > 30);
}

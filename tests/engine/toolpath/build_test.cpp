#include "tests/engine/toolpath/shapes.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using toolpath::Role;

TEST_CASE("a solid box takes as much plastic as its volume") {
  auto s = bare_settings();
  s.slice.infill_density = 1.0;
  const auto plan = toolpath::build(box_stack(20, 30, 5), s);
  REQUIRE(plan.layers.size() == 25);
  CHECK(volume_mm3(plan) == Approx(20.0 * 30.0 * 5.0).epsilon(0.03));
}

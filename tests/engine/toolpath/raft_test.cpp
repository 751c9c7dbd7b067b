#include "engine/toolpath/adhesion/raft.h"

#include "engine/toolpath/bead.h"
#include "tests/engine/toolpath/shapes.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

bool is_support(const toolpath::Path& p) {
  return p.role == Role::support || p.role == Role::support_interface;
}

toolpath::PrintSettings on_raft(int layers) {
  toolpath::PrintSettings s = bare_settings();
  s.slice.raft_layers = layers;
  s.slice.raft_gap_mm = 0.15;
  s.slice.first_layer_height_mm = 0.3;
  return s;
}

}  // namespace

TEST_CASE("a raft lifts the part by its layers and the air above them") {
  const auto stack = box_stack(20, 20, 2);
  for (const int layers : {1, 2, 4}) {
    const auto s = on_raft(layers);
    const auto plan = toolpath::build(stack, s);
    REQUIRE(plan.layers.size() == static_cast<std::size_t>(layers) + stack.size());
    const double top = 0.3 + 0.2 * (layers - 1);
    CHECK(toolpath::raft_lift_mm(s.slice) == Approx(top + 0.15));
    CHECK(plan.layers[0].span.top_mm == Approx(0.3));
    const auto n = static_cast<std::size_t>(layers);
    CHECK(plan.layers[n - 1].span.top_mm == Approx(top));
    CHECK(plan.layers[n].span.bottom_mm == Approx(top + 0.15));
    CHECK(plan.layers.back().span.top_mm == Approx(top + 0.15 + 2));
    for (std::size_t i = 0; i < plan.layers.size(); ++i) {
      CHECK(plan.layers[i].outline.empty() == (i < n));
      for (const auto& p : plan.layers[i].paths) CHECK(is_support(p) == (i < n));
    }
  }
}

TEST_CASE("a raft lies under all of the part, dense on top") {
  const auto s = on_raft(4);
  const auto stack = box_stack(20, 30, 1);
  const auto plan = toolpath::build(stack, s);
  const auto under = geom::offset(stack[0].regions, from_mm(s.slice.raft_margin_mm - 0.5));
  const auto reach =
      geom::offset(stack[0].regions, from_mm(s.slice.raft_margin_mm + 0.05), geom::Join::round);
  auto share = [&](std::size_t i) {
    const auto beads = covered(plan.layers[i], is_support);
    CHECK(geom::to_mm2(geom::area(geom::subtract(beads, reach))) < 0.01);
    return geom::area(geom::intersect(beads, under)) / geom::area(under);
  };
  CHECK(share(0) == Approx(0.75).margin(0.1));
  CHECK(share(1) == Approx(0.55).margin(0.1));
  CHECK(share(2) > 0.98);
  CHECK(share(3) > 0.98);
  CHECK(count(plan.layers[3], Role::support_interface) > 0);
  // As much plastic as the layers above it hold.
  double volume = 0;
  for (const auto& p : plan.layers[3].paths) volume += volume_mm3(p);
  CHECK(volume == Approx(0.2 * geom::to_mm2(geom::area(reach))).epsilon(0.08));
}

TEST_CASE("on a raft the part's first layer is one like the others, without brim") {
  auto s = on_raft(3);
  s.slice.brim_width_mm = 5;
  s.slice.elephant_foot_mm = 0.2;
  s.slice.first_layer_line_width_mm = 0.6;
  const auto plan = toolpath::build(box_stack(20, 20, 2), s);
  for (const auto& p : plan.layers[3].paths) {
    CHECK(p.role != Role::skirt_brim);
    if (p.role == Role::external_perimeter) CHECK(p.width_mm == Approx(0.45));
  }
  CHECK(geom::to_mm2(geom::area(plan.layers[3].outline)) == Approx(400));
  CHECK(plan.layers[0].paths.front().width_mm == Approx(0.6));
}

TEST_CASE("support stands on the raft itself") {
  auto s = on_raft(3);
  s.slice.support = toolpath::SupportMode::plate;
  const auto stack = mushroom_stack(24, 6, 1, 6);
  const auto plan = toolpath::build(stack, s);
  std::size_t n = 0;
  for (const auto& p : plan.layers[3].paths) {
    if (!is_support(p)) continue;
    ++n;
    CHECK(p.height_mm == Approx(0.2 + 0.15));
    CHECK(p.area_mm2 == Approx(toolpath::bead_area_mm2(p.width_mm, 0.35)));
  }
  CHECK(n > 0);
  const auto raft = covered(plan.layers[2], is_support, 0.05);
  CHECK(geom::to_mm2(geom::area(geom::subtract(plan.layers[3].support, raft))) < 0.5);
}

TEST_CASE("the skirt goes around the raft") {
  auto s = on_raft(2);
  s.slice.skirt_loops = 1;
  s.slice.skirt_layers = 3;
  const auto stack = box_stack(20, 20, 2);
  const auto plan = toolpath::build(stack, s);
  const auto raft = geom::offset(stack[0].regions, from_mm(s.slice.raft_margin_mm), geom::Join::round);
  const auto near = geom::offset(raft, from_mm(s.slice.skirt_gap_mm - 0.1), geom::Join::round);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(count(plan.layers[i], Role::skirt_brim) == (i < 3 ? 1u : 0u));
    for (const auto& p : plan.layers[i].paths)
      if (p.role == Role::skirt_brim) CHECK(geom::clip_inside({line_of(p)}, near).empty());
  }
}

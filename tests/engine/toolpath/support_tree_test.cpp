#include "engine/toolpath/support/support_tree.h"

#include "engine/toolpath/support/support_task.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;
using toolpath::SupportMode;
using toolpath::SupportStyle;

namespace {

bool is_support(const toolpath::Path& p) {
  return p.role == Role::support || p.role == Role::support_interface;
}

toolpath::PrintSettings settings(SupportStyle style, SupportMode mode = SupportMode::everywhere) {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  s.slice.support = mode;
  s.slice.support_style = style;
  return s;
}

double support_mm3(const toolpath::Plan& plan) {
  double sum = 0;
  for (const auto& layer : plan.layers)
    for (const auto& p : layer.paths) sum += is_support(p) ? volume_mm3(p) : 0.0;
  return sum;
}

slice::LayerStack ball_on_post(double radius) {
  return stack_of(2 * radius + 4, 0.2, [=](double z) {
    const double h = z - 4 - radius;
    const double r = std::max(std::sqrt(std::max(0.0, radius * radius - h * h)), z < radius + 4 ? 2.0 : 0.0);
    return geom::Regions{{geom::make_circle({from_mm(80), from_mm(80)}, from_mm(r), 64), {}}};
  });
}

/// A wide foot, a post and a wide cap: below the cap lies the foot everywhere.
slice::LayerStack spool_stack(double foot, double cap, double height) {
  return stack_of(height, 0.2, [=](double z) {
    const double half = 0.5 * (z < 2 ? foot : z > height - 1.5 ? cap : 5.0);
    return geom::Regions{rectangle(80 - half, 80 - half, 80 + half, 80 + half)};
  });
}

std::vector<slice::LayerStack> overhanging() {
  return {mushroom_stack(30, 16, 1, 6), ball_on_post(9), arch_stack(40, 10, 12, 2, 4),
          spool_stack(30, 26, 20)};
}

double area_mm2(const geom::Regions& r) { return geom::to_mm2(geom::area(r)); }

/// Points of layer i that nothing below carries, a millimetre apart.
std::vector<geom::Point> overhang_samples(const slice::LayerStack& stack, std::size_t i, double lean_mm) {
  std::vector<geom::Point> out;
  const auto hanging = geom::subtract(stack[i].regions, geom::offset(stack[i - 1].regions, from_mm(lean_mm)));
  for (const auto& region : hanging) {
    const auto box = *geom::bounds(region.outer);
    for (auto x = box.min.x; x <= box.max.x; x += from_mm(1))
      for (auto y = box.min.y; y <= box.max.y; y += from_mm(1))
        if (geom::contains(region, {x, y})) out.push_back({x, y});
  }
  return out;
}

bool near_any(const geom::Regions& regions, const geom::Point& p, double reach_mm) {
  const auto r = from_mm(reach_mm);
  return !geom::intersect(regions, {{geom::make_circle(p, r, 32), {}}}).empty();
}

}  // namespace

TEST_CASE("support never touches the part, in either style") {
  for (const auto style : {SupportStyle::grid, SupportStyle::tree}) {
    const auto s = settings(style);
    const auto stacks = overhanging();
    for (std::size_t k = 0; k < stacks.size(); ++k) {
      const auto& stack = stacks[k];
      const auto plan = toolpath::build(stack, s);
      REQUIRE(support_mm3(plan) > 5);
      // Beads of the measure have square ends, which stick out a little where a line turns.
      for (std::size_t i = 0; i < stack.size(); ++i) {
        const auto beads = covered(plan.layers[i], is_support);
        if (beads.empty()) continue;
        CAPTURE(static_cast<int>(style), k, i);
        const auto beside = geom::offset(stack[i].regions, from_mm(s.slice.support_xy_gap_mm - 0.1));
        CHECK(area_mm2(geom::intersect(beads, beside)) < 1e-3);
        for (std::size_t j = 0; j < stack.size(); ++j) {
          const double gap = std::max(stack[j].span.bottom_mm - stack[i].span.top_mm,
                                      stack[i].span.bottom_mm - stack[j].span.top_mm);
          if (gap > s.slice.support_z_gap_mm - 1e-6) continue;
          CHECK(area_mm2(geom::intersect(beads, geom::offset(stack[j].regions, -from_mm(0.1)))) < 1e-3);
        }
      }
    }
  }
}

TEST_CASE("every overhang has support within reach, the gap below it") {
  for (const auto style : {SupportStyle::grid, SupportStyle::tree})
    for (const int roofs : {0, 2}) {
      auto s = settings(style);
      s.slice.support_interface_layers = roofs;
      const std::vector<slice::LayerStack> stacks{mushroom_stack(22, 10, 1, 6), ball_on_post(8),
                                                  spool_stack(24, 20, 12)};
      for (std::size_t k = 0; k < stacks.size(); ++k) {
        const auto& stack = stacks[k];
        const auto plan = toolpath::build(stack, s);
        // Without a roof the tips themselves hold; beside the part the xy gap has no support.
        const double reach = style == SupportStyle::tree && roofs == 0 ? s.slice.tree_tip_distance_mm
                                                                       : s.slice.support_xy_gap_mm + 0.5;
        std::size_t seen = 0;
        for (std::size_t i = 1; i < stack.size(); ++i) {
          const std::size_t below = toolpath::layer_below_gap(stack, i, s.slice.support_z_gap_mm);
          if (below == stack.size()) continue;
          for (const auto& p : overhang_samples(stack, i, 0.2 * std::tan(45 * 3.14159265 / 180) + 0.01)) {
            ++seen;
            CAPTURE(static_cast<int>(style), roofs, k, i, geom::to_mm(p.x), geom::to_mm(p.y));
            CHECK(near_any(plan.layers[below].support, p, reach));
          }
        }
        CHECK(seen > 10);
      }
    }
}

TEST_CASE("a strut that begins in the air with a point is held there") {
  // Too small for a line at first, it widens by less than may lean out.
  const auto stack = stack_of(14, 0.2, [](double z) {
    if (z > 12) return geom::Regions{rectangle(50, 50, 80, 60)};
    geom::Regions out{rectangle(50, 50, 56, 60)};
    const double r = 0.7 * (z - 4.05);
    if (r > 0.01) out.push_back({geom::make_circle({from_mm(72), from_mm(55)}, from_mm(r), 32), {}});
    return out;
  });
  for (const auto style : {SupportStyle::grid, SupportStyle::tree}) {
    const auto s = settings(style);
    const auto plan = toolpath::build(stack, s);
    CAPTURE(static_cast<int>(style));
    CHECK(near_any(plan.layers[18].support, {from_mm(72), from_mm(55)}, 0.1));
    CHECK(plan.layers[0].support.size() > 0);
  }
}

TEST_CASE("branches go on down to the plate, or to the part where they may") {
  for (const auto mode : {SupportMode::plate, SupportMode::everywhere}) {
    const auto s = settings(SupportStyle::tree, mode);
    const auto stacks = overhanging();
    for (std::size_t k = 0; k < stacks.size(); ++k) {
      const auto& stack = stacks[k];
      const auto plan = toolpath::build(stack, s);
      for (std::size_t i = 1; i < stack.size(); ++i) {
        const std::size_t below = toolpath::layer_below_gap(stack, i, s.slice.support_z_gap_mm);
        for (const auto& region : plan.layers[i].support) {
          bool held = !geom::intersect({region}, plan.layers[i - 1].support).empty();
          if (mode == SupportMode::everywhere && below < stack.size())
            held = held || !geom::intersect({region}, stack[below].regions).empty();
          CAPTURE(static_cast<int>(mode), k, i, area_mm2({region}));
          CHECK(held);
        }
      }
    }
  }
}

TEST_CASE("branches lean out around the part where columns from the plate cannot stand") {
  const auto stack = spool_stack(20, 24, 24);
  const auto grid = toolpath::build(stack, settings(SupportStyle::grid, SupportMode::plate));
  const auto tree = toolpath::build(stack, settings(SupportStyle::tree, SupportMode::plate));
  const std::size_t under = 112 - 2;  // the cap's underside at 22.5 mm
  const geom::Region middle = rectangle(74, 74, 86, 86);
  CHECK(area_mm2(geom::intersect(grid.layers[under].support, {middle})) < 0.1);
  CHECK(area_mm2(geom::intersect(tree.layers[under].support, {middle})) > 60);
  // Nothing of it stands on the foot: it may lean over the edge by a step.
  const auto foot = geom::offset(stack[5].regions, -from_mm(0.5));
  for (std::size_t i = 10; i < 13; ++i) CHECK(area_mm2(geom::intersect(tree.layers[i].support, foot)) < 1e-3);
}

TEST_CASE("a roof reaches no further than what is below it bears") {
  // A closed box whose floor covers three quarters of it: from the plate only some of the lid is in reach.
  const auto stack = stack_of(9, 0.2, [](double z) {
    geom::Regions box{rectangle(60, 60, 100, 100)};
    if (z < 8) box = geom::subtract(box, {rectangle(62, 62, 98, 98)});
    if (z < 1) box = geom::unite(geom::rings_of({box.front(), rectangle(60, 60, 100, 90)}));
    return box;
  });
  const auto plan = toolpath::build(stack, settings(SupportStyle::tree, SupportMode::plate));
  std::size_t seen = 0;
  for (std::size_t i = 1; i < stack.size(); ++i)
    for (const auto& path : plan.layers[i].paths)
      for (const auto& p : path.points) {
        if (path.role != Role::support_interface) continue;
        ++seen;
        CAPTURE(i, geom::to_mm(p.x), geom::to_mm(p.y));
        CHECK(near_any(plan.layers[i - 1].support, p, 1.6));
      }
  CHECK(seen > 100);
}

TEST_CASE("a small area is held, though branches of others pass beside it") {
  // A post whose cap is held all around, and a slat right below the cap's edge, 0.6 mm off its branches.
  const auto stack = stack_of(16, 0.2, [](double z) {
    geom::Regions out;
    if (z < 14) out.push_back(rectangle(78, 78, 82, 82));
    if (z >= 14) out.push_back(rectangle(70, 70, 90, 90));
    if (z >= 12 && z < 14) out.push_back(rectangle(89, 79, 90, 81));
    return out;
  });
  const auto plan = toolpath::build(stack, settings(SupportStyle::tree));
  const std::size_t i = 60, below = toolpath::layer_below_gap(stack, i, 0.2);
  REQUIRE(stack[i].regions.size() > stack[i - 1].regions.size());
  CHECK(near_any(plan.layers[below].support, {from_mm(89.5), from_mm(80)}, 0.1));
}

TEST_CASE("a tree takes less plastic than a grid below a mushroom, and little of the plate") {
  const auto stack = mushroom_stack(40, 24, 1, 6);
  const auto grid = toolpath::build(stack, settings(SupportStyle::grid));
  const auto tree = toolpath::build(stack, settings(SupportStyle::tree));
  CHECK(support_mm3(tree) < 0.6 * support_mm3(grid));
  CHECK(area_mm2(tree.layers[0].support) < 0.5 * area_mm2(grid.layers[0].support));
  CHECK(tree.layers[40].support.size() < tree.layers[110].support.size());  // they have become one
}

TEST_CASE("nothing is supported that bridges, thin or wide") {
  for (const auto style : {SupportStyle::grid, SupportStyle::tree}) {
    for (const double width : {0.8, 3.0, 12.0}) {
      CAPTURE(static_cast<int>(style), width);
      CHECK(support_mm3(toolpath::build(arch_stack(18, width, 8, 2, 4), settings(style))) == 0);
      CHECK(support_mm3(toolpath::build(arch_stack(40, width, 8, 2, 4), settings(style))) > 0);
    }
  }
}

TEST_CASE("walls around a hole in the air are supported, though strips beside them bridge") {
  // A screw's hole at the bottom of the wider one for its head, printed head down.
  for (const auto& [head, hole] : {std::pair{6.2, 3.4}, std::pair{5.0, 2.9}, std::pair{4.0, 2.4}}) {
    CAPTURE(head);
    const auto stack = stack_of(6, 0.2, [head = head, hole = hole](double z) {
      geom::Region r = rectangle(50, 50, 66, 66);
      geom::Ring ring =
          geom::make_circle({from_mm(58), from_mm(58)}, from_mm((z < 2.8 ? head : hole) / 2), 48);
      geom::reverse(ring);
      r.holes.push_back(ring);
      return geom::Regions{r};
    });
    CHECK(support_mm3(toolpath::build(stack, settings(SupportStyle::grid))) > 0);
  }
}

TEST_CASE("trees are the same from one thread and from many") {
  const auto s = settings(SupportStyle::tree);
  for (const auto& stack : {mushroom_stack(22, 10, 1, 6), spool_stack(24, 20, 12)}) {
    run::Context one;
    one.threads = 1;
    run::Context many;
    many.threads = 5;
    const auto a = toolpath::build(stack, s, one);
    const auto b = toolpath::build(stack, s, many);
    REQUIRE(a.layers.size() == b.layers.size());
    for (std::size_t i = 0; i < a.layers.size(); ++i) {
      REQUIRE(a.layers[i].paths.size() == b.layers[i].paths.size());
      for (std::size_t p = 0; p < a.layers[i].paths.size(); ++p)
        REQUIRE(a.layers[i].paths[p].points == b.layers[i].paths[p].points);
    }
  }
}

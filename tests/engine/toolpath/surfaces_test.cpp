#include "engine/toolpath/fill/surfaces.h"

#include "engine/toolpath/bead.h"
#include "engine/toolpath/draft.h"
#include "engine/toolpath/emit/pace.h"
#include "engine/toolpath/support/supports.h"
#include "tests/engine/toolpath/shapes.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

double mm2(const geom::Regions& r) { return geom::to_mm2(geom::area(r)); }

bool is_solid(const toolpath::Path& p) {
  return p.role != Role::infill && p.role != Role::support && p.role != Role::support_interface;
}
bool is_part(const toolpath::Path& p) {
  return p.role != Role::support && p.role != Role::support_interface && p.role != Role::skirt_brim;
}

/// Area of each layer that must be solid (some layer within the shells is missing above or below) and is
/// not under a solid bead; beads are widened by a hair so that rounding leaves no cracks.
double open_skin_mm2(const slice::LayerStack& stack, const toolpath::Plan& plan,
                     const toolpath::SliceSettings& s) {
  double worst = 0;
  const auto n = static_cast<std::ptrdiff_t>(stack.size());
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const auto& own = stack[static_cast<std::size_t>(i)].regions;
    geom::Regions inside = own;
    for (std::ptrdiff_t k = -s.bottom_layers; k <= s.top_layers; ++k) {
      const std::ptrdiff_t j = i + k;
      inside = j < 0 || j >= n ? geom::Regions{}
                               : geom::intersect(inside, stack[static_cast<std::size_t>(j)].regions);
    }
    const geom::Regions skin = geom::subtract(own, inside);
    const geom::Regions solid = covered(plan.layers[static_cast<std::size_t>(i)], is_solid, 0.04);
    CAPTURE(i);
    // Corners that a round bead cannot reach, and steps below the printable, stay open.
    worst = std::max(worst, mm2(geom::open(geom::subtract(skin, solid), from_mm(0.12))));
  }
  return worst;
}

}  // namespace

TEST_CASE("top and bottom skins are closed") {
  auto s = bare_settings();
  s.slice.top_layers = 3;
  s.slice.bottom_layers = 2;
  for (const auto& stack :
       {box_stack(20, 15, 4), cup_stack(30, 5, 2.5, 1.2), cone_stack(15, 4, 5), arch_stack(24, 12, 8, 3, 5)})
    CHECK(open_skin_mm2(stack, toolpath::build(stack, s), s.slice) < 0.15);
}

TEST_CASE("a box has exactly its shells solid and sparse infill between them") {
  auto s = bare_settings();
  s.slice.top_layers = 5;
  s.slice.bottom_layers = 4;
  const auto plan = toolpath::build(box_stack(30, 30, 6), s);
  const std::size_t n = plan.layers.size();
  for (std::size_t i = 0; i < n; ++i) {
    const bool shell = i < 4 || i >= n - 5;
    CHECK((count(plan.layers[i], Role::infill) == 0) == shell);
    CHECK((count(plan.layers[i], Role::solid_infill) + count(plan.layers[i], Role::internal_bridge) > 0) ==
          (shell && i + 1 < n));
    CHECK((count(plan.layers[i], Role::top_solid_infill) > 0) == (i + 1 == n));
  }
}

TEST_CASE("shells are as thick as asked where the count of layers makes less") {
  auto s = bare_settings();
  s.slice.top_layers = 2;
  s.slice.bottom_layers = 1;
  for (const double layer : {0.1, 0.2, 0.3})
    for (const double thickness : {0.0, 0.35, 0.8, 1.2}) {
      s.slice.top_thickness_mm = thickness;
      s.slice.bottom_thickness_mm = thickness / 2;
      CAPTURE(layer, thickness);
      const auto plan = toolpath::build(box_stack(30, 30, 6, layer), s);
      const auto at_least = [&](double mm, int layers) {
        return std::max(layers, static_cast<int>(std::ceil(mm / layer - 1e-6)));
      };
      const auto n = static_cast<int>(plan.layers.size());
      const int top = at_least(thickness, 2), bottom = at_least(thickness / 2, 1);
      for (int i = 0; i < n; ++i)
        CHECK((count(plan.layers[static_cast<std::size_t>(i)], Role::infill) == 0) ==
              (i < bottom || i >= n - top));
    }
  s.slice.top_layers = 0;
  CHECK(count(toolpath::build(box_stack(30, 30, 6), s).layers.back(), Role::infill) > 0);
}

TEST_CASE("a skin reaches a line's width under the solid beside it") {
  auto s = bare_settings();
  s.slice.top_layers = 3;
  // A step: the lower half's top ends where the upper half's wall stands.
  const auto stack = stack_of(12, 0.2, [](double z) {
    return geom::Regions{z < 6 ? rectangle(50, 50, 90, 70) : rectangle(50, 50, 70, 70)};
  });
  std::vector<geom::Regions> inner;
  for (std::size_t i = 0; i < stack.size(); ++i)
    inner.push_back(toolpath::inner_of(toolpath::draft_walls(stack[i], i, s.slice)));
  const auto surfaces = toolpath::find_surfaces(stack, inner, s.slice, {});
  const auto& last = surfaces[29];  // the step's top layer
  const auto box = *geom::bounds(last.top);
  CHECK(geom::to_mm(box.min.x) ==
        Approx(70 - toolpath::kSkinAnchorWidths * s.slice.line_width_mm).margin(0.01));
  CHECK(geom::to_mm(geom::bounds(last.sparse)->max.x) == Approx(geom::to_mm(box.min.x)).margin(0.01));
}

TEST_CASE("solid over sparse infill is bridged across its lines, slower and with the bridge's flow") {
  auto s = bare_settings();
  s.slice.bridge_flow = 0.9;
  s.cooling.slow_below_s = 0;
  const auto plan = toolpath::build(box_stack(40, 30, 6), s);
  const std::size_t first = plan.layers.size() - 5;  // five top layers
  double hanging = 0;
  for (std::size_t i = 0; i < plan.layers.size(); ++i) {
    CHECK((count(plan.layers[i], Role::internal_bridge) > 0) == (i == first));
    for (const auto& p : plan.layers[i].paths)
      if (p.role == Role::internal_bridge) hanging += length_mm(p) * s.slice.line_width_mm;
  }
  CHECK(hanging > 0.85 * 38 * 28);
  auto direction = [](const toolpath::LayerPlan& layer, Role role) {
    for (const auto& p : layer.paths)
      if (p.role == role) {
        std::size_t longest = 0;
        for (std::size_t k = 0; k + 1 < p.points.size(); ++k)
          if (geom::distance(p.points[k], p.points[k + 1]) >
              geom::distance(p.points[longest], p.points[longest + 1]))
            longest = k;
        const auto &a = p.points[longest], &b = p.points[longest + 1];
        return std::atan2(static_cast<double>(b.y - a.y), static_cast<double>(b.x - a.x));
      }
    return 0.0;
  };
  const double between =
      direction(plan.layers[first], Role::internal_bridge) - direction(plan.layers[first - 1], Role::infill);
  CHECK(std::abs(std::cos(between)) < 0.02);
  for (const auto& p : plan.layers[first].paths)
    if (p.role == Role::internal_bridge) {
      CHECK(toolpath::path_speed_mm_s(p, first, s) == s.speed.internal_bridge);
      CHECK(p.area_mm2 == Approx(0.9 * toolpath::bead_spacing_mm(0.45, 0.2) * 0.2).epsilon(0.16));
    }
  CHECK(toolpath::keeps_speed(Role::internal_bridge));
  s.slice.infill_density = 0.6;  // its gaps are narrower than a bead
  for (const auto& layer : toolpath::build(box_stack(40, 30, 6), s).layers)
    CHECK(count(layer, Role::internal_bridge) == 0);
}

TEST_CASE("over a hollow, the roof inside runs the shorter way") {
  auto s = bare_settings();
  s.slice.infill_density = 0;
  const auto plan = toolpath::build(box_stack(40, 12, 6), s);
  const auto& layer = plan.layers[plan.layers.size() - 5];
  REQUIRE(count(layer, Role::internal_bridge) > 0);
  double x = 0, y = 0;
  for (const auto& p : layer.paths)
    if (p.role == Role::internal_bridge)
      for (std::size_t k = 0; k + 1 < p.points.size(); ++k) {
        x += std::abs(geom::to_mm(p.points[k + 1].x - p.points[k].x));
        y += std::abs(geom::to_mm(p.points[k + 1].y - p.points[k].y));
      }
  CHECK(y > 10 * x);
}

TEST_CASE("sparse areas below the limit are solid") {
  auto s = bare_settings();
  s.slice.min_infill_area_mm2 = 30;
  CHECK(count(toolpath::build(box_stack(6, 6, 6), s).layers[15], Role::infill) == 0);
  CHECK(count(toolpath::build(box_stack(12, 12, 6), s).layers[15], Role::infill) > 0);
}

TEST_CASE("a bridge spans the gap between its legs") {
  const auto b =
      toolpath::plan_bridge(rectangle(4, 0, 16, 10), {rectangle(0, 0, 4, 10), rectangle(16, 0, 20, 10)}, 0.8);
  CHECK(b.anchored);
  CHECK(std::abs(std::sin(b.angle_rad)) < 0.02);
  CHECK(b.span_mm == Approx(12).margin(0.01));
  const auto free = toolpath::plan_bridge(rectangle(4, 0, 16, 10), {rectangle(0, 0, 4, 10)}, 0.8);
  CHECK_FALSE(free.anchored);
  // Legs thinner than the bridge reaches are hold enough.
  const auto thin = toolpath::plan_bridge(rectangle(4, 0, 16, 10),
                                          {rectangle(3.4, 0, 4, 10), rectangle(16, 0, 16.6, 10)}, 1.5);
  CHECK(thin.anchored);

  auto s = bare_settings();
  const auto plan = toolpath::build(arch_stack(20, 10, 6, 2, 4), s);
  const auto& layer = plan.layers[20];
  CHECK(count(layer, Role::bridge_infill) > 0);
  CHECK(count(layer, Role::overhang_perimeter) > 0);
  for (const auto& p : layer.paths)
    if (p.role == Role::bridge_infill)
      CHECK(p.area_mm2 == Approx(3.14159265 / 4 * s.machine.nozzle_mm * s.machine.nozzle_mm));
  CHECK(count(plan.layers[21], Role::bridge_infill) == 0);
}

TEST_CASE("support keeps its distance from the part and stands on something") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  for (const auto mode : {toolpath::SupportMode::plate, toolpath::SupportMode::everywhere}) {
    s.slice.support = mode;
    for (const auto& stack :
         {mushroom_stack(24, 6, 1, 6), arch_stack(60, 10, 6, 2, 4), cone_stack(3, 6, 16)}) {
      const auto plan = toolpath::build(stack, s);
      std::size_t lines = 0;
      for (std::size_t i = 0; i < plan.layers.size(); ++i) {
        geom::Polylines support;
        double width = 0;
        for (const auto& p : plan.layers[i].paths)
          if (!is_part(p)) support.push_back(line_of(p)), width = std::max(width, p.width_mm);
        if (support.empty()) continue;
        ++lines;
        const double beside = s.slice.support_xy_gap_mm + width / 2 - 0.04;
        CHECK(geom::clip_inside(support, geom::offset(stack[i].regions, from_mm(beside))).empty());
        // One layer of gap above it.
        if (i + 1 < stack.size())
          CHECK(geom::clip_inside(support, geom::offset(stack[i + 1].regions, from_mm(width / 2 - 0.04)))
                    .empty());
      }
      CHECK(lines > 10);
    }
  }
}

TEST_CASE("short bridges and steep walls get no support; support can be switched off") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  auto supported = [&](const slice::LayerStack& stack) {
    std::size_t n = 0;
    for (const auto& layer : toolpath::build(stack, s).layers)
      n += count(layer, Role::support) + count(layer, Role::support_interface);
    return n;
  };
  CHECK(supported(arch_stack(16, 10, 6, 2, 4)) == 0);
  CHECK(supported(arch_stack(60, 10, 6, 2, 4)) > 0);
  CHECK(supported(cone_stack(3, 6, 8)) == 0);  // leans out by 40°
  CHECK(supported(cone_stack(3, 6, 12)) > 0);  // by 56°
  s.slice.support_angle_deg = 60;
  CHECK(supported(cone_stack(3, 6, 12)) == 0);
  s.slice.support_angle_deg = 45;
  s.slice.support = toolpath::SupportMode::none;
  CHECK(supported(arch_stack(60, 10, 6, 2, 4)) == 0);
}

TEST_CASE("support from the plate alone never stands on the part") {
  // A roof on a wall above a wide floor: its overhang can only be held from the floor.
  const auto stack = stack_of(8, 0.2, [](double z) {
    if (z < 1) return geom::Regions{rectangle(50, 50, 80, 70)};
    return geom::Regions{z < 6 ? rectangle(50, 50, 54, 70) : rectangle(50, 50, 74, 70)};
  });
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  auto total = [&] {
    double sum = 0;
    for (const auto& layer : toolpath::build(stack, s).layers)
      for (const auto& p : layer.paths) sum += is_part(p) ? 0 : length_mm(p);
    return sum;
  };
  CHECK(total() > 100);
  s.slice.support = toolpath::SupportMode::plate;
  CHECK(total() == 0);
}

#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

bool is_support(const toolpath::Path& p) {
  return p.role == Role::support || p.role == Role::support_interface;
}
bool is_part(const toolpath::Path& p) { return !is_support(p) && p.role != Role::skirt_brim; }

/// A strand between two held ends may hang this far, mm.
constexpr double kMaxStrandMm = 12.0;
/// The tip of a line may stick out over air by this, mm: its other half holds it.
constexpr double kMaxTipMm = 0.5;

/// What holds the beads of layer i: the beads below, as far as they carry at the angle that needs no support,
/// and support whose top lies the gap below, its lines taken together where they are a line apart at most.
geom::Regions held_at(const toolpath::Plan& plan, std::size_t i, const toolpath::SliceSettings& s) {
  const double height = plan.layers[i].span.height_mm();
  const double lean =
      std::max(height * std::tan(s.support_angle_deg * 3.14159265358979 / 180), 0.25 * s.line_width_mm);
  // Sparse infill carries what crosses it; walls beside it are close enough to be crossed as well.
  const double infill_gap = s.line_width_mm / s.infill_density;
  geom::Regions held = covered(plan.layers[i - 1], is_part, lean);
  held = geom::unite(
      held, geom::intersect(geom::close(held, from_mm(0.6 * infill_gap)), plan.layers[i - 1].outline));
  for (std::size_t k = i; k-- > 0;) {
    const double gap = plan.layers[i].span.bottom_mm - plan.layers[k].span.top_mm;
    if (gap < s.support_z_gap_mm - 1e-6) continue;
    if (gap > s.support_z_gap_mm + height) break;
    const geom::Regions support = covered(plan.layers[k], is_support, 0.05);
    held = geom::unite(held, geom::close(support, from_mm(0.5 * s.line_width_mm)));
    break;
  }
  return held;
}

/// What layer i prints of the part without lifting: a wall may be cut into stretches of different speed.
geom::Polylines strands(const toolpath::LayerPlan& layer) {
  geom::Polylines out;
  const toolpath::Path* before = nullptr;
  for (const auto& path : layer.paths) {
    if (!is_part(path)) continue;
    const bool goes_on =
        before != nullptr && !before->closed && !path.closed && before->points.back() == path.points.front();
    if (goes_on)
      out.back().insert(out.back().end(), path.points.begin() + 1, path.points.end());
    else
      out.push_back(line_of(path));
    before = &path;
  }
  return out;
}

/// Length of what layer i prints on nothing, mm.
double loose_mm(const toolpath::Plan& plan, std::size_t i, const toolpath::SliceSettings& s) {
  const geom::Regions held = held_at(plan, i, s);
  double loose = 0;
  for (const geom::Polyline& line : strands(plan.layers[i])) {
    const bool closed = line.front() == line.back();
    for (const auto& piece : geom::clip_outside({line}, held)) {
      const double length = geom::length(piece) / geom::kNmPerMm;
      const bool starts = !closed && piece.front() == line.front();
      const bool ends = !closed && piece.back() == line.back();
      if (length <= (starts || ends ? kMaxTipMm : kMaxStrandMm) && !(starts && ends)) continue;
      loose += length;
    }
  }
  return loose;
}

double loose_mm(const toolpath::Plan& plan, const toolpath::SliceSettings& s) {
  double sum = 0;
  for (std::size_t i = 1; i < plan.layers.size(); ++i) sum += loose_mm(plan, i, s);
  return sum;
}

/// A round body on a post 1 mm high, so that support has room below it; `radius_at` its height.
slice::LayerStack turned_stack(double height, const std::function<double(double)>& radius_at) {
  return stack_of(height + 1, 0.2, [=](double z) {
    const double r = std::max(z > 1 ? radius_at(z - 1) : 0.0, 3.0);
    return geom::Regions{{geom::make_circle({from_mm(80), from_mm(80)}, from_mm(r), 64), {}}};
  });
}

slice::LayerStack ball_stack(double radius) {
  return turned_stack(2 * radius, [=](double z) {
    return std::sqrt(std::max(0.0, radius * radius - (z - radius) * (z - radius)));
  });
}

/// Leans out by 72°.
slice::LayerStack funnel_stack() {
  return turned_stack(6, [](double z) { return 3 + z * 3; });
}

/// An arm along x with a bar hanging down from its tip: the bar begins in the air.
slice::LayerStack hook_stack() {
  return stack_of(16, 0.2, [](double z) {
    if (z > 12) return geom::Regions{rectangle(50, 50, 80, 60)};
    if (z > 6) return geom::Regions{rectangle(50, 50, 56, 60), rectangle(74, 52, 80, 58)};
    return geom::Regions{rectangle(50, 50, 56, 60)};
  });
}

/// A shelf over a row of thin struts, which lean so that no way straight down passes between them, and on
/// none of which anything can stand.
slice::LayerStack thicket_stack() {
  return stack_of(19, 0.2, [](double z) {
    geom::Regions out{rectangle(40, 46, 44, 58)};
    if (z > 18) return geom::unite(out, {rectangle(44, 51, 49, 53)});
    if (z < 12) {
      const double x = 44.6 + std::max(z - 4, 0.0) * 0.7;
      for (int k = 0; k < 6; ++k) out.push_back(rectangle(x, 48.7 + 1.4 * k, x + 0.6, 49.3 + 1.4 * k));
    }
    return out;
  });
}

std::vector<slice::LayerStack> overhanging() {
  return {arch_stack(60, 10, 6, 2, 4),
          arch_stack(32, 10, 6, 2, 4),
          mushroom_stack(24, 6, 1, 6),
          funnel_stack(),
          ball_stack(10),
          hook_stack()};
}

}  // namespace

TEST_CASE("nothing is printed in mid-air but strands between two held ends") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  auto stacks = overhanging();
  for (const auto& stack : {arch_stack(20, 10, 6, 2, 4), arch_stack(16, 10, 6, 2, 2), cup_stack(30, 5, 2, 1),
                            cone_stack(3, 6, 8), cone_stack(3, 6, 16), cone_stack(16, 6, 3)})
    stacks.push_back(stack);
  for (const auto style : {toolpath::SupportStyle::grid, toolpath::SupportStyle::tree}) {
    s.slice.support_style = style;
    for (std::size_t k = 0; k < stacks.size(); ++k) {
      const auto plan = toolpath::build(stacks[k], s);
      for (std::size_t i = 1; i < plan.layers.size(); ++i) {
        CAPTURE(static_cast<int>(style), k, i);
        CHECK(loose_mm(plan, i, s.slice) < 1.0);
      }
    }
  }
}

TEST_CASE("the mid-air law sees overhangs that lost their support") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  const auto stacks = overhanging();
  for (std::size_t k = 0; k < stacks.size(); ++k) {
    CAPTURE(k);
    auto plan = toolpath::build(stacks[k], s);
    CHECK(loose_mm(plan, s.slice) < 1.0);
    for (auto& layer : plan.layers) std::erase_if(layer.paths, is_support);
    CHECK(loose_mm(plan, s.slice) > 20.0);
  }
}

TEST_CASE("where no column can stand branches lean out around what is in the way") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  const auto stack = thicket_stack();
  auto plan = toolpath::build(stack, s);
  CHECK(loose_mm(plan, s.slice) < 0.5);
  const auto under_the_tip = [&](std::size_t i) {
    return geom::area(geom::intersect(covered(plan.layers[i], is_support), {rectangle(46, 50, 50, 54)}));
  };
  CHECK(under_the_tip(88) > 3e12);
  for (auto& layer : plan.layers) std::erase_if(layer.paths, is_support);
  CHECK(loose_mm(plan, s.slice) > 3.0);
}

TEST_CASE("an island that begins with a point between struts is held where it widens") {
  toolpath::PrintSettings s;
  s.slice.skirt_loops = 0;
  auto stack = thicket_stack();
  for (std::size_t i = 90; i < stack.size(); ++i) {
    const double half = i == 90 ? 0.15 : 0.7;
    stack[i].regions = {rectangle(40, 46, 44, 58), rectangle(47.5 - half, 52 - half, 47.5 + half, 52 + half)};
  }
  const auto plan = toolpath::build(stack, s);
  // The widening's underside lies at the top of layer 90; support keeps the gap of one layer.
  CHECK(geom::to_mm2(geom::area(geom::intersect(covered(plan.layers[89], is_support),
                                                {rectangle(46.8, 51.3, 48.2, 52.7)}))) > 1.0);
}

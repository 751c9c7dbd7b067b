#include "engine/toolpath/spiral_vase.h"

#include "engine/toolpath/emit/emit.h"
#include "engine/toolpath/walls/perimeters.h"
#include "tests/engine/toolpath/shapes.h"

#include <cmath>
#include <numbers>
#include <sstream>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;

namespace {

toolpath::PrintSettings vase_settings() {
  toolpath::PrintSettings s = bare_settings();
  s.slice.spiral_vase = true;
  s.slice.bottom_layers = 3;
  return s;
}

double printed_mm3(const toolpath::Path& p) {
  return volume_mm3(p) * (p.rise ? 0.5 * (p.rise->share_from + p.rise->share_to) : 1.0);
}

/// One foot that parts into two arms.
slice::LayerStack fork_stack() {
  return stack_of(8, 0.2, [](double z) {
    if (z < 3 || z > 6) return geom::Regions{rectangle(50, 50, 80, 60)};
    return geom::Regions{rectangle(50, 50, 60, 60), rectangle(70, 50, 80, 60)};
  });
}

}  // namespace

TEST_CASE("a vase is one line from its floor to its rim") {
  for (const auto& stack : {cone_stack(10, 12, 14), cone_stack(14, 12, 10), box_stack(20, 30, 12)}) {
    const auto plan = toolpath::build(stack, vase_settings());
    REQUIRE(plan.layers.size() == stack.size());
    const geom::Point* at = nullptr;
    double z = 0;
    for (std::size_t i = 3; i < plan.layers.size(); ++i) {
      const auto& paths = plan.layers[i].paths;
      const bool last = i + 1 == plan.layers.size();
      REQUIRE(paths.size() == (last ? 2u : 1u));
      for (const auto& p : paths) {
        CAPTURE(i);
        REQUIRE(p.rise);
        CHECK_FALSE(p.closed);
        if (at != nullptr) {
          CHECK(*at == p.points.front());
          CHECK(z == Approx(p.rise->from_mm));
        }
        at = &p.points.back();
        z = p.rise->to_mm;
      }
    }
    CHECK(z == Approx(stack.back().span.top_mm));
    for (std::size_t i = 0; i < 3; ++i)
      for (const auto& p : plan.layers[i].paths) CHECK_FALSE(p.rise);
  }
}

TEST_CASE("a vase's wall holds its contour times its height of plastic, evenly") {
  const auto stack = box_stack(20, 30, 12);
  const auto s = vase_settings();
  const auto plan = toolpath::build(stack, s);
  double volume = 0;
  for (std::size_t i = 3; i < plan.layers.size(); ++i)
    for (const auto& p : plan.layers[i].paths) volume += printed_mm3(p);
  const toolpath::BeadSize bead{s.slice.line_width_mm, 0.2};
  const double around = 2 * (20 + 30 - 2 * s.slice.line_width_mm);
  CHECK(volume == Approx(around * bead.area_mm2() * static_cast<double>(stack.size() - 3)).epsilon(1e-4));
  const auto& first = *plan.layers[3].paths[0].rise;
  CHECK(first.share_from == 0);
  CHECK(first.share_to == 1);
  CHECK(plan.layers[4].paths[0].rise->share_from == Approx(1));
  CHECK(plan.layers.back().paths[1].rise->share_to == 0);
}

TEST_CASE("a vase's rounds pass into one another without a step") {
  const auto stack = cone_stack(10, 8, 14, 64);  // 0.1 mm out per layer
  const auto plan = toolpath::build(stack, vase_settings());
  const geom::Point middle{from_mm(80), from_mm(80)};
  for (std::size_t i = 4; i < plan.layers.size(); ++i) {
    const auto& p = plan.layers[i].paths[0];
    double along = 0;
    const double whole = geom::length(p.points);
    for (std::size_t k = 0; k < p.points.size(); ++k) {
      if (k > 0) along += geom::distance(p.points[k - 1], p.points[k]);
      const double z = p.rise->from_mm + along / whole * (p.rise->to_mm - p.rise->from_mm);
      // Corners of the 64-gon lie on the cone; its wall half a line inside.
      const double radius = 10 + 4 * (z - 0.1) / 8 - 0.5 * 0.45;
      const double sag = radius * (1 - std::cos(std::numbers::pi / 64));
      CHECK(geom::distance(p.points[k], middle) / geom::kNmPerMm == Approx(radius).margin(sag + 0.02));
    }
  }
}

TEST_CASE("a vase's round keeps between its own contour and the one below, wherever their corners are") {
  const auto dozen = [](double turn, double radius) {
    geom::Ring ring;
    for (int k = 0; k < 12; ++k) {
      const double angle = (k + turn) * std::numbers::pi / 6;
      ring.push_back({from_mm(80 + radius * std::cos(angle)), from_mm(80 + radius * std::sin(angle))});
    }
    return ring;
  };
  const geom::Coord slack = from_mm(0.03);  // half way, edges keep to neither contour's corners
  for (const double grown : {-0.2, 0.0, 0.2}) {
    const geom::Ring below = dozen(0.5, 10), own = dozen(0, 10 + grown);
    const geom::Regions either = geom::offset(geom::unite(geom::Regions{{below, {}}}, {{own, {}}}), slack),
                        both = geom::offset(geom::intersect({{below, {}}}, {{own, {}}}), -slack);
    const geom::Point begin{(below.front().x + below.back().x) / 2, (below.front().y + below.back().y) / 2};
    const auto round = toolpath::vase_round(own, below, own.front(), begin);
    CAPTURE(grown);
    CHECK((round.front() == begin));
    CHECK((round.back() == own.front()));
    for (std::size_t k = 1; k < round.size(); ++k)
      for (int part = 0; part < 8; ++part) {
        const geom::Point &a = round[k - 1], &b = round[k];
        const geom::Point p{a.x + (b.x - a.x) * part / 8, a.y + (b.y - a.y) * part / 8};
        CHECK(geom::contains(either.front(), p));
        CHECK_FALSE(geom::contains(both.front(), p));
      }
  }
}

TEST_CASE("layers with several contours print as closed loops, and the spiral begins anew") {
  const auto plan = toolpath::build(fork_stack(), vase_settings());
  std::size_t loops = 0;
  for (const auto& layer : plan.layers) {
    if (layer.outline.size() != 2) continue;
    ++loops;
    REQUIRE(layer.paths.size() == 2);
    for (const auto& p : layer.paths) {
      CHECK(p.closed);
      CHECK_FALSE(p.rise);
    }
  }
  CHECK(loops == 15);
  CHECK(plan.layers[14].paths.size() == 2);  // round and rim
  CHECK(plan.layers[14].paths[1].rise->share_to == 0);
  CHECK(plan.layers[30].paths[0].rise->share_from == 0);
}

TEST_CASE("at sharp corners a vase's wall reaches into the tip, and hardly over the flanks") {
  const double half = 0.5 * 0.45;
  for (const double degrees : {25.0, 40.0, 60.0, 85.0, 90.0, 120.0}) {
    CAPTURE(degrees);
    // A kite with this angle at its tip.
    const double angle = degrees * std::numbers::pi / 180;
    const double wide = 20 * std::tan(0.5 * angle);
    const geom::Ring kite = {
        {0, 0}, {from_mm(20), from_mm(-wide)}, {from_mm(20 + wide), 0}, {from_mm(20), from_mm(wide)}};
    const geom::Rings contours = toolpath::vase_contours({{kite, {}}}, 2 * half);
    REQUIRE(contours.size() == 1);
    double tip = 1e9, over = 0, moved = 0;
    const auto n = contours.front().size();
    for (std::size_t i = 0; i < n; ++i)
      for (int part = 0; part < 50; ++part) {
        const geom::Point &a = contours.front()[i], &b = contours.front()[(i + 1) % n];
        const double x = geom::to_mm(a.x + (b.x - a.x) * part / 50);
        const double y = geom::to_mm(a.y + (b.y - a.y) * part / 50);
        tip = std::min(tip, x - half);
        // From the flanks that meet in the tip.
        if (x > 19) continue;
        const double inside = x * std::sin(0.5 * angle) - std::abs(y) * std::cos(0.5 * angle);
        over = std::max(over, half - inside);
        if (inside < half - 1e-3 && std::hypot(x, y) > half / std::sin(0.5 * angle) + 1.01) moved = x;
      }
    CHECK(over == Approx(degrees < 90 ? 0.04 : 0).margin(1e-4));
    CHECK(moved == 0);
    CHECK(tip == Approx((half - over) / std::sin(0.5 * angle) - half).margin(1e-3));
  }
}

TEST_CASE("a vase's wall reaches out where the part has a tip, not where its contour alone has one") {
  // A bar with round ends, hardly wider than the wall: what is left inside ends in points.
  const double radius = 0.235;
  geom::Ring bar;
  for (int k = 0; k <= 32; ++k) {
    const double angle = (k - 16) * std::numbers::pi / 32;
    bar.push_back({from_mm(80 + radius * std::cos(angle)), from_mm(80 + radius * std::sin(angle))});
  }
  const std::size_t end = bar.size();
  for (std::size_t k = 0; k < end; ++k) bar.push_back({from_mm(140) - bar[k].x, from_mm(160) - bar[k].y});
  const geom::Rings contours = toolpath::vase_contours({{bar, {}}}, 0.45);
  REQUIRE(contours.size() == 1);
  for (const geom::Point& p : contours.front()) {
    double nearest = 1e9;
    for (std::size_t k = 0; k < bar.size(); ++k)
      nearest = std::min(nearest, geom::distance(p, bar[k]) / geom::kNmPerMm);
    CHECK(nearest > 0.18);
  }
}

TEST_CASE("what is too thin for a vase's wall is one line down its middle") {
  const auto s = vase_settings();
  const auto lines = [](const toolpath::LayerPlan& layer) {
    double mm = 0;
    for (const auto& p : layer.paths) {
      if (p.role != Role::gap_fill) continue;
      CHECK_FALSE(p.rise);
      for (const auto& at : p.points) CHECK(std::abs(geom::to_mm(at.y) - 55) < 0.01);
      mm += geom::length(p.points) / geom::kNmPerMm;
    }
    return mm;
  };
  // A sheet of its own, a fin on a block, and a fin no longer than it may be missing.
  const auto sheet = stack_of(4, 0.2, [](double) { return geom::Regions{rectangle(50, 54.85, 80, 55.15)}; });
  const auto fin = [](double to) {
    return stack_of(4, 0.2, [=](double) {
      return geom::unite(geom::rings_of({rectangle(50, 50, 60, 60), rectangle(60, 54.85, to, 55.15)}));
    });
  };
  const auto thin = toolpath::build(sheet, s), finned = toolpath::build(fin(66), s),
             tipped = toolpath::build(fin(60.4), s);
  for (std::size_t i = 3; i < 20; ++i) {
    CAPTURE(i);
    CHECK(lines(thin.layers[i]) == Approx(30).margin(0.5));
    CHECK(lines(finned.layers[i]) == Approx(6).margin(0.5));
    CHECK(finned.layers[i].paths.front().rise);
    CHECK(lines(tipped.layers[i]) == 0);
  }
}

TEST_CASE("a vase's G-code climbs without a retraction") {
  auto s = vase_settings();
  s.slice.bottom_layers = 2;
  std::ostringstream out;
  toolpath::emit(toolpath::build(cone_stack(10, 6, 13), s), s, "", out, {});
  std::istringstream in(out.str());
  int layer = 0;
  double z = 0;
  double last_z = 0;
  std::size_t climbing = 0;
  double negative = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(";LAYER_CHANGE", 0) == 0) ++layer;
    if (layer < 4 || line.rfind("G1", 0) != 0) continue;
    const auto at = line.find(" Z");
    const auto e = line.find(" E");
    if (at != std::string::npos) {
      z = std::stod(line.substr(at + 2));
      CHECK(z >= last_z);
      last_z = z;
      if (e != std::string::npos && line.find(" X") != std::string::npos) ++climbing;
    }
    if (layer < 30 && e != std::string::npos) negative = std::min(negative, std::stod(line.substr(e + 2)));
    if (layer < 30) CHECK(e != std::string::npos);  // never travels
  }
  CHECK(layer == 30);
  CHECK(z == Approx(6));
  CHECK(climbing > 26 * 40);
  CHECK(negative == 0);
}

#include "engine/toolpath/support/trim_support.h"

#include "engine/toolpath/lean.h"
#include "tests/engine/toolpath/shapes.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Path;
using toolpath::Role;

namespace {

Path strand(const std::vector<std::pair<double, double>>& points, bool closed = false,
            Role role = Role::support) {
  Path out;
  out.role = role;
  out.closed = closed;
  for (const auto& [x, y] : points) out.points.push_back({from_mm(x), from_mm(y)});
  return out;
}

double length_mm(const std::vector<Path>& paths) {
  double sum = 0;
  for (const Path& p : paths) sum += geom::length(line_of(p)) / geom::kNmPerMm;
  return sum;
}

/// What is left of `own` over `below`; no part is near.
std::vector<Path> trimmed(std::vector<Path> own, std::vector<Path> below,
                          const slice::LayerStack& stack = box_stack(1, 1, 0.4)) {
  std::vector<std::vector<Path>*> lines{&below, &own};
  toolpath::trim_support(lines, stack, {}, {});
  return own;
}

const std::vector<Path> kRows{strand({{0, 0}, {20, 0}}), strand({{0, 2.8}, {20, 2.8}})};

}  // namespace

TEST_CASE("support on support stays as it is") {
  const auto left = trimmed(kRows, kRows);
  REQUIRE(left.size() == 2);
  CHECK(left[0].points == kRows[0].points);
  // A loop that leans out by a little, and one that ends a little further out.
  const Path loop = strand({{1, 0.1}, {19, 0.1}, {19, 2.7}, {1, 2.7}}, true);
  CHECK(trimmed({loop}, kRows).front().points == loop.points);
  CHECK(trimmed({strand({{-0.3, 0}, {20.3, 0}})}, kRows).size() == 1);
}

TEST_CASE("what lies between two lines is carried by them, what lies beside the last one is not") {
  CHECK(length_mm(trimmed({strand({{1, 1.4}, {19, 1.4}})}, kRows)) == Approx(18));
  CHECK(trimmed({strand({{1, 4.2}, {19, 4.2}})}, kRows).empty());
  CHECK(trimmed({strand({{1, 7}, {19, 7}})}, kRows).empty());
}

TEST_CASE("a dot over air stays, since it hangs no further than about its width") {
  const auto dot = [](double mm) { return trimmed({strand({{5, 7}, {5 + mm, 7}})}, kRows).size(); };
  CHECK(dot(0.38) == 1);
  CHECK(dot(0.45) == 0);
}

TEST_CASE("an end over air is cut off, and held again on the part") {
  const auto cut = trimmed({strand({{10, 0}, {26, 0}})}, kRows);
  REQUIRE(cut.size() == 1);
  CHECK(length_mm(cut) == Approx(10.5).margin(0.5));
  // The part two layers down: a layer of support and the z gap fit.
  auto stack = box_stack(1, 1, 0.6);
  stack[0].regions = {rectangle(24, -1, 30, 1)};
  std::vector<Path> first = kRows, second = kRows, third{strand({{10, 0}, {28, 0}})};
  std::vector<std::vector<Path>*> lines{&first, &second, &third};
  toolpath::trim_support(lines, stack, {}, {});
  // Held at both ends, but over a longer way than lines are apart.
  REQUIRE(third.size() == 2);
  CHECK(length_mm(third) == Approx(14.5).margin(0.5));
}

TEST_CASE("a loop keeps the part of it that is carried, wherever it begins") {
  const std::vector<std::pair<double, double>> corners{{15, 0}, {30, 0}, {30, 2.8}, {15, 2.8}};
  for (std::size_t k = 0; k < 4; ++k) {
    auto turned = corners;
    std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(k), turned.end());
    const auto left = trimmed({strand(turned, true)}, kRows);
    CHECK(length_mm(left) == Approx(12.8).margin(1.0));
    for (const Path& p : left) CHECK(!p.closed);
  }
}

TEST_CASE("lines across may hang from one line to the next") {
  const Path across = strand({{5, 0}, {5, 2.8}}, false, Role::support_interface);
  CHECK(trimmed({across}, kRows).front().points == across.points);
  const auto far = trimmed({strand({{5, 0}, {5, 9}}, false, Role::support_interface)}, kRows);
  REQUIRE(far.size() == 1);
  CHECK(length_mm(far) < 4.8);
}

TEST_CASE("a loop that hangs from row to row begins on one of them") {
  const Path loop = strand({{20.4, 1.4}, {20.4, 2.8}, {18, 2.8}, {18, 0}, {20.4, 0}}, true);
  const auto left = trimmed({loop}, kRows);
  REQUIRE(left.size() == 1);
  CHECK(!left[0].closed);
  CHECK(left[0].points.front() == left[0].points.back());
  CHECK(length_mm(left) == Approx(10.4));
  CHECK(std::abs(geom::to_mm(left[0].points.front().y) - 1.4) > 1.0);
}

TEST_CASE("what stood on what was cut is cut as well, layer for layer, and nothing beside it") {
  // Two rows that reach out over air from the second layer on, and one far away that stands.
  const Path apart = strand({{0, 60}, {20, 60}});
  std::vector<Path> ground = kRows;
  ground.push_back(apart);
  std::vector<Path> out{strand({{0, 0}, {40, 0}}), strand({{0, 2.8}, {40, 2.8}}), apart};
  std::vector<std::vector<Path>> layers{ground, out, out, out, out, out};
  std::vector<std::vector<Path>*> lines;
  for (auto& layer : layers) lines.push_back(&layer);
  for (const unsigned threads : {1u, 2u}) {
    run::Context ctx;
    ctx.threads = threads;
    toolpath::trim_support(lines, box_stack(1, 1, 2.0), {}, ctx);
    for (std::size_t i = 1; i < layers.size(); ++i) {
      REQUIRE(layers[i].size() == 3);
      for (std::size_t k : {0u, 1u})
        CHECK(length_mm({layers[i][k]}) == Approx(20.3 + 0.3 * static_cast<double>(i)).margin(0.5));
      CHECK(layers[i][2].points == apart.points);
    }
  }
}

TEST_CASE("a loop around the end of a line begins and ends on it") {
  // As where a column has just become wide enough for a border: below lies one line down its middle.
  const std::vector<Path> middle{strand({{0, 0}, {0, 4.2}})};
  std::vector<std::pair<double, double>> corners{{0.3, -0.5}, {0.3, 4.7}, {-0.3, 4.7}, {-0.3, -0.5}};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const auto left = trimmed({strand(corners, true)}, middle);
    REQUIRE(left.size() == 1);
    CHECK(length_mm(left) == Approx(11.6));
    for (const geom::Point& end : {left[0].points.front(), left[0].points.back()}) {
      CHECK(geom::to_mm(end.y) > 0.1);
      CHECK(geom::to_mm(end.y) < 4.1);
    }
    std::rotate(corners.begin(), corners.begin() + 1, corners.end());
  }
}

TEST_CASE("dense lines may go on beyond the last line as far as half way to where the next one would be") {
  const auto left = trimmed({strand({{1, 4.5}, {19, 4.5}}, false, Role::support_interface)}, kRows);
  CHECK(left.empty());
  CHECK(trimmed({strand({{1, 4.2}, {19, 4.2}}, false, Role::support_interface)}, kRows).size() == 1);
}

TEST_CASE("lines lean out as far as the angle allows, and no further") {
  const toolpath::SliceSettings s;
  const double most = toolpath::support_lean_mm(s, 0.2) + 0.5 * s.line_width_mm;
  const auto beside = [&](double by) { return trimmed({strand({{1, -by}, {19, -by}})}, kRows).size(); };
  CHECK(beside(most - 0.01) == 1);
  CHECK(beside(most + 0.01) == 0);
}

TEST_CASE("a pocket among lines that one disc has room in is not between them") {
  // A triangle around a circle larger than what lies between two lines: near its middle no line carries.
  std::vector<Path> walls;
  for (int k = 0; k < 3; ++k) {
    const double a = 2 * 3.14159265 * k / 3, r = 2.2, half = 6;
    const double x = r * std::cos(a), y = r * std::sin(a);
    walls.push_back(strand({{x - half * std::sin(a), y + half * std::cos(a)},
                            {x + half * std::sin(a), y - half * std::cos(a)}}));
  }
  const Path across = strand({{-4, 0.1}, {2.2, 0.1}});
  double hanging = 4;
  for (const Path& p : trimmed({across}, walls)) hanging = std::min(hanging, 6.2 - length_mm({p}));
  CHECK(hanging > 1.5);
}

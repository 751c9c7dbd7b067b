#include "tests/fidelity/sections.h"

#include "tests/support/meshes.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::fidelity;

namespace {

/// A square of `side` mm from (from, from) on.
Mask square(const Grid& grid, double from, double side) {
  const double to = from + side;
  return fill({{from, from, to, from}, {to, from, to, to}, {to, to, from, to}, {from, to, from, from}}, grid);
}

Mask disc(const Grid& grid, double middle, double radius) {
  Mask out(grid.count(), 0);
  Bead b;
  b.x0 = b.x1 = b.y0 = b.y1 = middle;
  b.width = 2 * radius;
  draw(out, grid, b);
  return out;
}

double area(const Mask& mask, const Grid& grid) { return static_cast<double>(count(mask)) * grid.area(); }

}  // namespace

TEST_CASE("a section is compensated by what the rules say") {
  const Grid grid{0, 0, 0.05, 260, 260};
  const double half = 0.5 * grid.size;
  const Mask body = square(grid, 2.01, 8);
  const Mask round = disc(grid, 6.01, 4);
  const Mask pierced = without(square(grid, 0.6, 11.8), round);
  for (const double by : {-0.2, -0.15, -0.1, -0.08, -0.03, 0.03, 0.08, 0.1, 0.15, 0.2}) {
    CAPTURE(by);
    // By whole pixels a border along them moves exactly, else by half of one more or less at most.
    const double pixels = by / grid.size;
    const bool whole = std::abs(pixels - std::round(pixels)) < 1e-9;
    // A growing corner stays a corner only as far as a disc reaches.
    const double corners = by > 0 ? (4 - std::numbers::pi) * by * by : 0;
    const double side = std::sqrt(area(compensated(body, grid, by, 0), grid) + corners);
    CHECK(0.5 * (side - 8) == Approx(by).margin(whole ? 0.01 * grid.size : half));
    const auto radius = [](double a) { return std::sqrt(a / std::numbers::pi); };
    CHECK(radius(area(compensated(round, grid, by, 0), grid)) == Approx(4 + by).margin(half));
    const Mask wider = compensated(pierced, grid, 0, by);
    CHECK(radius(area(without_holes(wider, grid), grid) - area(wider, grid)) == Approx(4 + by).margin(half));
  }
}

TEST_CASE("islands are compensated each for itself, wherever they lie") {
  const Grid grid{0, 0, 0.05, 260, 260};
  const Mask frame = without(square(grid, 0.6, 11.8), square(grid, 1.6, 9.8));
  const Mask ring = without(disc(grid, 6.5, 4), disc(grid, 6.5, 2.5));
  const Mask pin = disc(grid, 6.5, 1);
  const std::vector<Mask> islands{frame, ring, pin};
  Mask all(grid.count(), 0);
  for (const Mask& island : islands)
    for (std::size_t p = 0; p < all.size(); ++p) all[p] |= island[p];
  for (const auto& [outer, hole] : {std::pair{0.15, 0.0}, {-0.15, 0.2}, {0.1, -0.1}}) {
    CAPTURE(outer, hole);
    Mask alone(grid.count(), 0);
    for (const Mask& island : islands) {
      const Mask now = compensated(island, grid, outer, hole);
      for (std::size_t p = 0; p < alone.size(); ++p) alone[p] |= now[p];
    }
    CHECK((compensated(all, grid, outer, hole) == alone));
    CHECK(count(alone) != count(all));
  }
}

TEST_CASE(
    "on the first layer thin walls may keep their width, however coarse the pixels and wherever they lie") {
  Print print;
  print.layers.resize(1);
  print.layers.front().top = print.layers.front().height = 0.2;
  Rules rules;
  rules.foot = 0.2;
  const double thin = 2 * rules.foot + rules.line_width;
  for (const double size : {0.05, 0.08, 0.12})
    for (const double shift : {0.0, 0.2, 0.4, 0.6, 0.8}) {
      const Grid grid{0, 0, size, static_cast<int>(4 / size), static_cast<int>(12 / size)};
      const auto most = [&](double width) {
        const auto wall = test::moved(test::box(width, 10, 1), 1 + shift * size, 1, 0);
        return area(Sections(wall, print, rules, grid).of(0).most, grid);
      };
      CAPTURE(size, shift);
      CHECK(most(thin - 0.02) > 10 * (thin - 0.02 - 1.01 * size));
      CHECK(most(thin + 3 * size) < 10 * (thin + 3 * size - 1.5 * rules.foot));
    }
}

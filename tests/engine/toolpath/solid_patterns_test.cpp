#include "engine/toolpath/fill/concentric_fill.h"
#include "engine/toolpath/fill/fermat_fill.h"
#include "engine/toolpath/walls/gap_lines.h"
#include "tests/engine/toolpath/shapes.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

using namespace voidpath;
using namespace voidpath::test;
using geom::from_mm;
using toolpath::Role;
using toolpath::SolidPattern;

namespace {

const toolpath::BeadSize kBead{0.45, 0.2};

geom::Ring hole_at(double x, double y, double radius) {
  geom::Ring hole = geom::make_circle({from_mm(x), from_mm(y)}, from_mm(radius), 40);
  geom::reverse(hole);
  return hole;
}

geom::Region ring_of(std::initializer_list<std::pair<double, double>> points) {
  geom::Region r;
  for (const auto& [x, y] : points) r.outer.push_back({from_mm(x), from_mm(y)});
  return r;
}

/// Areas with one and several innermost contours, with holes, with necks, long and round.
std::vector<geom::Region> areas() {
  std::vector<geom::Region> out;
  out.push_back(rectangle(0, 0, 20, 14));
  out.push_back({geom::make_circle({}, from_mm(9), 90), {}});
  out.push_back(rectangle(0, 0, 60, 3.3));
  out.push_back({geom::make_circle({}, from_mm(12), 90), {hole_at(0, 0, 5)}});
  out.push_back({rectangle(0, 0, 40, 20).outer, {hole_at(10, 10, 4), hole_at(28, 11, 5), hole_at(19, 4, 2)}});
  // Two squares joined by a neck.
  out.push_back(ring_of({{0, 0},
                         {12, 0},
                         {12, 4.5},
                         {20, 4.5},
                         {20, 0},
                         {32, 0},
                         {32, 12},
                         {20, 12},
                         {20, 7.5},
                         {12, 7.5},
                         {12, 12},
                         {0, 12}}));
  geom::Region star;
  for (int i = 0; i < 14; ++i) {
    const double a = 2 * std::numbers::pi * i / 14;
    const double d = i % 2 == 0 ? 16 : 8;
    star.outer.push_back({from_mm(d * std::cos(a)), from_mm(d * std::sin(a))});
  }
  out.push_back(star);
  // An E.
  out.push_back(ring_of({{0, 0},
                         {20, 0},
                         {20, 5},
                         {5, 5},
                         {5, 9},
                         {18, 9},
                         {18, 14},
                         {5, 14},
                         {5, 18},
                         {20, 18},
                         {20, 24},
                         {0, 24}}));
  return out;
}

toolpath::LayerPlan printed(const toolpath::RingFill& fill) {
  toolpath::LayerPlan layer;
  for (const auto& line : fill.lines.lines) {
    toolpath::Path path;
    path.role = Role::solid_infill;
    path.points = line;
    path.closed = fill.lines.closed;
    path.area_mm2 = kBead.area_mm2();
    layer.paths.push_back(path);
  }
  toolpath::add_gap_lines(layer.paths, fill.gaps, kBead, 0.0125);
  return layer;
}

geom::Regions reached(const geom::Region& domain) {
  return geom::offset({domain}, from_mm(0.5 * kBead.spacing_mm()));
}

double mm2(const geom::Regions& r) { return geom::to_mm2(geom::area(r)); }

/// Proper crossings of a line with itself.
std::size_t crossings(const geom::Polyline& line) {
  auto side = [](const geom::Point& a, const geom::Point& b, const geom::Point& c) {
    const auto v =
        static_cast<__int128>(b.x - a.x) * (c.y - a.y) - static_cast<__int128>(b.y - a.y) * (c.x - a.x);
    return v > 0 ? 1 : v < 0 ? -1 : 0;
  };
  std::size_t n = 0;
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    for (std::size_t j = i + 2; j + 1 < line.size(); ++j) {
      const auto &a = line[i], &b = line[i + 1], &c = line[j], &d = line[j + 1];
      if (side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0) ++n;
    }
  return n;
}

}  // namespace

TEST_CASE("Fermat spirals print each area in one line that does not cross itself") {
  std::size_t k = 0;
  for (const auto& domain : areas()) {
    CAPTURE(k++);
    const auto fill = toolpath::fermat_fill(domain, kBead);
    REQUIRE(fill.lines.lines.size() == 1);
    CHECK_FALSE(fill.lines.closed);
    const auto& line = fill.lines.lines.front();
    CHECK(geom::clip_outside({line}, geom::offset({domain}, from_mm(0.02))).empty());
    CHECK(crossings(line) == 0);
    // It ends beside where it began: on the outermost contour.
    CHECK(geom::distance(line.front(), line.back()) < 2 * geom::kNmPerMm);
  }
}

TEST_CASE("lines along the border cover the area with its own amount of plastic") {
  std::size_t k = 0;
  for (const auto& domain : areas())
    for (const bool fermat : {false, true}) {
      CAPTURE(k, fermat);
      const auto fill =
          fermat ? toolpath::fermat_fill(domain, kBead) : toolpath::concentric_fill(domain, kBead);
      const auto layer = printed(fill);
      const auto all = [](const toolpath::Path&) { return true; };
      const geom::Regions area = reached(domain);
      const geom::Regions bare = geom::subtract(area, covered(layer, all, 0.02));
      // What remains are the corners that beads pass round.
      CHECK(mm2(bare) < 0.025 * mm2(area));
      CHECK(geom::open(bare, from_mm(0.25)).empty());
      double volume = 0, gaps = 0;
      for (const auto& path : layer.paths) {
        volume += volume_mm3(path);
        if (path.role == Role::gap_fill) gaps += volume_mm3(path);
      }
      CHECK(volume / kBead.height_mm == Approx(mm2(area)).epsilon(0.06));
      CHECK(gaps < 0.12 * volume);
      ++k;
    }
}

TEST_CASE("the pattern of solid layers and of the top is as set") {
  auto s = bare_settings();
  auto paths_of = [&](std::size_t layer, Role role) {
    const auto plan = toolpath::build(box_stack(20, 16, 4), s);
    std::vector<toolpath::Path> out;
    for (const auto& p : plan.layers[layer].paths)
      if (p.role == role) out.push_back(p);
    return out;
  };
  s.slice.solid_pattern = SolidPattern::fermat;
  s.slice.top_pattern = SolidPattern::concentric;
  const auto bottom = paths_of(0, Role::solid_infill);
  REQUIRE(bottom.size() == 1);
  CHECK(length_mm(bottom.front()) > 500);
  const auto top = paths_of(19, Role::top_solid_infill);
  CHECK(top.size() > 10);
  for (const auto& p : top) CHECK(p.closed);
  s.slice.top_pattern = SolidPattern::rectilinear;
  const auto lines = paths_of(19, Role::top_solid_infill);
  CHECK(lines.size() < 4);
}

#include "engine/slice/adaptive_layers.h"

#include "engine/slice/layer_heights.h"
#include "engine/slice/slice_mesh.h"
#include "engine/slice/slope_profile.h"
#include "tests/support/meshes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

namespace voidpath::slice {

namespace {

using mesh::TriangleMesh;

/// A square pyramid's frustum: its sides lean by the same angle everywhere.
TriangleMesh frustum(double base, double top, double height) {
  TriangleMesh out = test::box(base, base, height);
  const double half = 0.5 * base;
  for (auto& v : out.vertices) {
    if (v.z() < 0.5 * height) continue;
    v.x() = half + (v.x() - half) * top / base;
    v.y() = half + (v.y() - half) * top / base;
  }
  return out;
}

void require_sound(const std::vector<LayerSpan>& spans, const TriangleMesh& mesh, const AdaptiveOptions& o) {
  REQUIRE_FALSE(spans.empty());
  CHECK(spans[0].bottom_mm == 0);
  CHECK(spans[0].top_mm == o.first_layer_mm);
  for (std::size_t i = 1; i < spans.size(); ++i) {
    CHECK(spans[i].bottom_mm == spans[i - 1].top_mm);
    CHECK(spans[i].height_mm() >= o.min_mm - 1e-9);
    CHECK(spans[i].height_mm() <= o.max_mm + 1e-9);
  }
  const double top = mesh::bounds(mesh).max.z();
  if (top > o.first_layer_mm) CHECK(std::abs(spans.back().top_mm - top) <= 0.5 * o.min_mm + 0.01);
}

bool has_border(const std::vector<LayerSpan>& spans, double z) {
  return std::any_of(spans.begin(), spans.end(),
                     [&](const LayerSpan& s) { return std::abs(s.top_mm - z) < 1e-6; });
}

}  // namespace

TEST_CASE("what a layer misses of a slope is its height squared over four, by the slope's projection") {
  // Sides lean by 1 mm over 2 mm: projection of all four per mm of height is the change of the section.
  const TriangleMesh mesh = frustum(20, 10, 10);
  const SlopeProfile slopes(mesh, 0, 0.005, 2000);
  for (const auto& [a, b] : {std::pair{200, 240}, {1000, 1056}, {1800, 1816}}) {
    const double za = 0.005 * a;
    const double zb = 0.005 * b;
    const double side_a = 20 - za;
    const double side_b = 20 - zb;
    const auto m = slopes.misfit(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
    CHECK(m.slope_mm2 == Approx(side_a * side_a - side_b * side_b).epsilon(1e-6));
    const double per_mm = 0.5 * (side_a + side_b) * 2;  // the rate changes by little in one layer
    CHECK(m.volume_mm3 == Approx(per_mm * (zb - za) * (zb - za) / 4).epsilon(0.02));
    CHECK(m.slope_mm3 / m.volume_mm3 == Approx(0.5 / std::hypot(1, 0.5)).epsilon(1e-6));
  }
  CHECK(slopes.volume_above_mm3(0) == Approx(mesh::volume(mesh)).epsilon(1e-5));
  CHECK(slopes.volume_above_mm3(1000) == Approx((15 * 15 * 15 - 10 * 10 * 10) / 3.0).epsilon(1e-5));
  CHECK(std::abs(slopes.volume_above_mm3(2000)) < 1e-6);
}

TEST_CASE("adaptive layers keep to their limits and end at the top") {
  const std::vector<TriangleMesh> meshes{
      test::cube(10),  test::cylinder(6, 7.77),          test::sphere(9),
      test::cube(0.1), test::cup(20, 16, 12.03, 2, 1.1), frustum(20, 4, 9)};
  for (const auto& mesh : meshes)
    for (const AdaptiveOptions& o :
         {AdaptiveOptions{}, AdaptiveOptions{0.3, 0.1, 0.1, 0.03}, AdaptiveOptions{0.2, 0.05, 0.35, 0.004},
          AdaptiveOptions{0.25, 0.15, 0.2, 0.5}}) {
      CAPTURE(mesh.triangles.size(), o.min_mm, o.max_mm);
      require_sound(adaptive_layers(mesh, o), mesh, o);
    }
  CHECK_THROWS_AS(adaptive_layers(test::cube(3), {0.2, 0.3, 0.2, 0.03}), std::invalid_argument);
  CHECK_THROWS_AS(adaptive_layers(test::cube(3), {0.2, 0.0, 0.2, 0.03}), std::invalid_argument);
}

TEST_CASE("upright walls get the fewest layers, all nearly as thick") {
  const auto spans = adaptive_layers(test::box(20, 10, 15), {0.2, 0.08, 0.28, 0.03});
  CHECK(spans.size() == 1 + 53);  // 14.8 / 0.28 = 52.9
  CHECK(spans.back().top_mm == Approx(15));
  for (std::size_t i = 1; i < spans.size(); ++i) CHECK(spans[i].height_mm() == Approx(0.28).margin(0.0101));
}

TEST_CASE("a slope is cut as finely as its error asks") {
  // Along the normal, steps of height h lie h/4 × the normal's z off on average.
  for (const double lean : {0.5, 1.0, 2.0, 4.0}) {  // mm out for each mm up
    const double normal_z = lean / std::hypot(1.0, lean);
    const double wanted = std::clamp(4 * 0.03 / normal_z, 0.08, 0.28);
    const auto spans = adaptive_layers(frustum(80, 80 - 2 * lean * 5, 5), {0.2, 0.08, 0.28, 0.03});
    double most = 0;
    for (std::size_t i = 1; i < spans.size(); ++i) most = std::max(most, spans[i].height_mm());
    CAPTURE(lean, wanted);
    CHECK(most <= wanted + 1e-9);
    CHECK(static_cast<double>(spans.size() - 1) <= std::ceil(4.8 / (std::floor(wanted * 100) / 100)) + 1);
  }
}

TEST_CASE("a sphere is cut finely at its poles and coarsely at its waist") {
  const TriangleMesh ball = test::sphere(10, 96, 96);
  const AdaptiveOptions o{0.2, 0.06, 0.3, 0.02};
  const auto spans = adaptive_layers(ball, o);
  auto height_at = [&](double z) {
    for (const auto& s : spans)
      if (s.top_mm > z) return s.height_mm();
    return 0.0;
  };
  CHECK(height_at(10) > 0.27);
  CHECK(height_at(19) < 0.12);
  CHECK(height_at(3) > height_at(0.6));
  // Fewer layers than equal ones of the same error in volume.
  auto missed = [&](const std::vector<LayerSpan>& of) {
    double sum = 0;
    for (const Layer& l : slice_mesh(ball, of))
      sum += geom::to_mm2(geom::area(l.regions)) * l.span.height_mm();
    return sum;
  };
  CHECK(missed(spans) == Approx(mesh::volume(ball)).epsilon(0.003));
  const SlopeProfile slopes(ball, 0.2, 0.005, 3960);
  auto misfit = [&](const std::vector<LayerSpan>& of) {
    double sum = 0;
    for (std::size_t i = 1; i < of.size(); ++i) {
      const auto a = static_cast<std::size_t>(std::llround((of[i].bottom_mm - 0.2) / 0.005));
      const auto b = static_cast<std::size_t>(std::llround((of[i].top_mm - 0.2) / 0.005));
      sum += slopes.misfit(a, std::min<std::size_t>(b, 3960)).volume_mm3;
    }
    return sum;
  };
  const double mean = 19.8 / static_cast<double>(spans.size() - 1);
  const double equal = 0.02 * std::floor(mean / 0.02);  // thinner than the mean: more layers
  CHECK(misfit(spans) < misfit(equal_layers(20, 0.2, equal)));
}

TEST_CASE("borders between layers lie on horizontal faces") {
  TriangleMesh steps = test::box(30, 30, 3.37);
  steps = test::joined(steps, test::moved(test::box(20, 20, 5.11), 5, 5, 0));
  steps = test::joined(steps, test::moved(test::box(10, 10, 8.05), 10, 10, 0));
  const auto spans = adaptive_layers(steps, {0.2, 0.1, 0.3, 0.03});
  for (const double z : {3.37, 5.11, 8.05}) {
    CAPTURE(z);
    CHECK(has_border(spans, z));
  }
}

}  // namespace voidpath::slice

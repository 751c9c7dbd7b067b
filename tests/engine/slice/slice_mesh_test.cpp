#include "engine/slice/slice_mesh.h"

#include "engine/geom/polygon_ops.h"
#include "engine/slice/layer_heights.h"
#include "tests/support/meshes.h"

#include <cmath>
#include <memory>
#include <mutex>

#include <catch2/catch.hpp>

namespace voidpath::slice {

namespace {

using geom::to_mm2;
using mesh::TriangleMesh;

double area_mm2(const geom::Regions& regions) { return to_mm2(geom::area(regions)); }

double volume_of(const LayerStack& layers) {
  double sum = 0;
  for (const Layer& l : layers) sum += area_mm2(l.regions) * l.span.height_mm();
  return sum;
}

LayerStack sliced(const TriangleMesh& mesh, double layer_mm, const run::Context& ctx = {}) {
  return slice_mesh(mesh, equal_layers(mesh::bounds(mesh).max.z(), layer_mm, layer_mm), {}, ctx);
}

void require_well_formed(const LayerStack& layers) {
  for (const Layer& l : layers)
    for (const geom::Region& r : l.regions) {
      REQUIRE(geom::area(r.outer) > 0);
      for (const geom::Ring& hole : r.holes) REQUIRE(geom::area(hole) < 0);
    }
}

TriangleMesh inverted(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

std::vector<std::pair<std::string, TriangleMesh>> shapes() {
  return {{"cube", test::cube(10)},
          {"cylinder", test::cylinder(7, 12)},
          {"cup", test::cup(20, 16, 12, 2, 1)},
          {"comb", test::comb(5, 3, 2, 8, 2)},
          {"table", test::table(20, 14, 10, 2, 3)},
          {"sphere", test::sphere(8)},
          {"two shells", test::joined(test::cube(5), test::moved(test::sphere(4), 12, 0, 0))}};
}

}  // namespace

TEST_CASE("equal layers stand on each other and end within half a layer of the top") {
  for (const double height : {0.05, 0.2, 0.29, 0.3, 0.31, 5.0, 10.0, 10.1, 33.333}) {
    const auto spans = equal_layers(height, 0.3, 0.2);
    REQUIRE_FALSE(spans.empty());
    CHECK(spans.front().bottom_mm == 0);
    CHECK(spans.front().top_mm == 0.3);
    for (std::size_t i = 1; i < spans.size(); ++i) {
      CHECK(spans[i].bottom_mm == spans[i - 1].top_mm);
      CHECK(spans[i].height_mm() == Approx(0.2));
    }
    if (height > 0.3) CHECK(std::abs(spans.back().top_mm - height) <= 0.1 + 1e-6);
  }
  CHECK(equal_layers(10, 0.2, 0.2).size() == 50);
  CHECK(equal_layers(0.5, 0.2, 0.2).size() == 3);   // half a layer gets a whole one
  CHECK(equal_layers(0.49, 0.2, 0.2).size() == 2);  // less does not
  CHECK(equal_layers(0, 0.2, 0.2).empty());
  CHECK_THROWS_AS(equal_layers(10, 0, 0.2), std::invalid_argument);
  CHECK_THROWS_AS(equal_layers(10, 0.2, -1), std::invalid_argument);
}

TEST_CASE("a cube has its square in every layer") {
  const LayerStack layers = sliced(test::cube(10), 0.25);
  REQUIRE(layers.size() == 40);
  for (const Layer& l : layers) {
    REQUIRE(l.regions.size() == 1);
    CHECK(geom::area(l.regions) == 1e14);
    CHECK(geom::bounds(l.regions) == geom::Box{{0, 0}, {10'000'000, 10'000'000}});
  }
}

TEST_CASE("a vertex at the plane counts as above: the bottom face is not cut, the top face is") {
  const TriangleMesh cube = test::cube(10);
  CHECK(slice_at(cube, 0).empty());
  CHECK(area_mm2(slice_at(cube, std::nextafter(0.0, 1.0))) == 100);
  CHECK(area_mm2(slice_at(cube, 10)) == 100);
  CHECK(slice_at(cube, std::nextafter(10.0, 11.0)).empty());
  CHECK(slice_at(cube, -1).empty());
}

TEST_CASE("a step at the plane belongs to what lies below it") {
  // Floor 1, walls above; plate from 8 to 10 on legs.
  const TriangleMesh cup = test::cup(20, 16, 12, 2, 1);
  CHECK(area_mm2(slice_at(cup, 1)) == 20 * 16);
  CHECK(area_mm2(slice_at(cup, std::nextafter(1.0, 2.0))) == Approx(20 * 16 - 16 * 12));
  const TriangleMesh table = test::table(20, 14, 10, 2, 3);
  CHECK(area_mm2(slice_at(table, 8)) == 4 * 9);
  CHECK(area_mm2(slice_at(table, std::nextafter(8.0, 9.0))) == 20 * 14);
  // The same through the one-pass slicer, whose planes fall on the steps.
  const LayerStack layers = slice_mesh(table, {{0, 2}, {7, 9}, {9, 11}});
  CHECK(area_mm2(layers[1].regions) == 36);
  CHECK(area_mm2(layers[2].regions) == 280);
}

TEST_CASE("planes through the vertices of a sphere cut closed contours") {
  // With as many rings as layers every plane meets a ring of vertices or a pole.
  const TriangleMesh ball = test::sphere(10, 20, 24);
  for (std::size_t i = 1; i < 20; ++i) {
    const double z = ball.vertices[1 + (i - 1) * 24].z();
    const auto r = slice_at(ball, z);
    REQUIRE(r.size() == 1);
    CHECK(r[0].outer.size() == 24);
    const double radius = 10 * std::sin(M_PI * static_cast<double>(i) / 20);
    CHECK(area_mm2(r) == Approx(12 * radius * radius * std::sin(M_PI / 12)).epsilon(1e-5));
  }
}

TEST_CASE("areas times thicknesses add up to the volume") {
  for (const auto& [name, mesh] : shapes()) {
    INFO(name);
    const LayerStack layers = sliced(mesh, 0.05);
    require_well_formed(layers);
    CHECK(volume_of(layers) == Approx(mesh::volume(mesh)).epsilon(2e-3));
  }
}

TEST_CASE("mirrored, turned and moved parts have the same areas") {
  const geom::Quaternion turn(Eigen::AngleAxisd(0.7, geom::Vec3::UnitZ()));
  for (const auto& [name, mesh] : shapes()) {
    INFO(name);
    TriangleMesh mirrored = inverted(mesh);
    for (auto& v : mirrored.vertices) v.x() = -v.x();
    const LayerStack plain = sliced(mesh, 0.23);
    for (const TriangleMesh& other :
         {mirrored, mesh::rotated(mesh, turn), test::moved(mesh, 31.4, -7.7, 0), inverted(mesh)}) {
      const LayerStack layers = sliced(other, 0.23);
      REQUIRE(layers.size() == plain.size());
      for (std::size_t i = 0; i < layers.size(); ++i) {
        CHECK(layers[i].regions.size() == plain[i].regions.size());
        CHECK(area_mm2(layers[i].regions) == Approx(area_mm2(plain[i].regions)).epsilon(1e-6).margin(1e-6));
      }
    }
  }
}

TEST_CASE("known contour counts") {
  CHECK(slice_at(test::comb(5, 3, 2, 8, 2), 5).size() == 5);
  CHECK(slice_at(test::comb(5, 3, 2, 8, 2), 1).size() == 1);
  CHECK(slice_at(test::table(20, 14, 10, 2, 3), 4).size() == 4);
  const auto ring = slice_at(test::cup(20, 16, 12, 2, 1), 6);
  REQUIRE(ring.size() == 1);
  CHECK(ring[0].holes.size() == 1);
}

TEST_CASE("shells: inner ones are holes, overlapping ones unite, a lone inverted one still prints") {
  const TriangleMesh big = test::cube(10);
  const TriangleMesh small = test::moved(test::cube(4), 3, 3, 3);
  CHECK(area_mm2(slice_at(test::joined(big, inverted(small)), 5)) == 100 - 16);
  CHECK(area_mm2(slice_at(test::joined(big, small), 5)) == 100);
  CHECK(area_mm2(slice_at(test::joined(big, test::moved(big, 5, 0, 0)), 5)) == 150);
  CHECK(slice_at(test::joined(big, test::moved(big, 5, 0, 0)), 5).size() == 1);
  // Touching, side on side, and the very same body twice.
  CHECK(area_mm2(slice_at(test::joined(big, test::moved(big, 10, 0, 0)), 5)) == 200);
  CHECK(area_mm2(slice_at(test::joined(big, big), 5)) == 100);
  CHECK(area_mm2(slice_at(inverted(big), 5)) == 100);
  // An island in a cavity.
  const TriangleMesh islet = test::moved(test::cube(1), 4.5, 4.5, 4.5);
  const auto r = slice_at(test::joined(test::joined(big, inverted(small)), islet), 5);
  REQUIRE(r.size() == 2);
  CHECK(area_mm2(r) == 100 - 16 + 1);
}

TEST_CASE("missing facets are bridged by the shortest gap") {
  // Each facet in turn: all are needed by some layer, none loses the part.
  for (const auto& [name, mesh] : shapes()) {
    if (name == "sphere" || name == "cylinder" || name == "two shells") continue;
    for (std::size_t drop = 0; drop < mesh.triangles.size(); ++drop) {
      INFO(name << " without facet " << drop);
      TriangleMesh holed = mesh;
      holed.triangles.erase(holed.triangles.begin() + static_cast<std::ptrdiff_t>(drop));
      const LayerStack layers = sliced(holed, 0.5);
      require_well_formed(layers);
      CHECK(volume_of(layers) == Approx(volume_of(sliced(mesh, 0.5))).epsilon(1e-6));
    }
  }
  // Smooth parts lose only what bulges over the chord of the gap.
  for (const auto& mesh : {test::sphere(8), test::cylinder(7, 12)})
    for (std::size_t drop = 0; drop < mesh.triangles.size(); drop += 7) {
      TriangleMesh holed = mesh;
      holed.triangles.erase(holed.triangles.begin() + static_cast<std::ptrdiff_t>(drop));
      CHECK(volume_of(sliced(holed, 0.5)) == Approx(volume_of(sliced(mesh, 0.5))).epsilon(5e-4));
    }
}

TEST_CASE("facets that look the wrong way do not tear the contour") {
  const TriangleMesh ball = test::sphere(8);
  for (std::size_t flip = 0; flip < ball.triangles.size(); flip += 11) {
    TriangleMesh bad = ball;
    std::swap(bad.triangles[flip][1], bad.triangles[flip][2]);
    CHECK(volume_of(sliced(bad, 0.5)) == Approx(volume_of(sliced(ball, 0.5))).epsilon(1e-6));
  }
}

TEST_CASE("a mesh that was never welded is joined at its cracks") {
  const TriangleMesh ball = test::sphere(8);
  TriangleMesh soup;
  double wiggle = 0;
  for (const auto& t : ball.triangles) {
    const auto base = static_cast<std::uint32_t>(soup.vertices.size());
    for (const auto v : t) {
      wiggle = std::fmod(wiggle + 0.618, 1.0);
      soup.vertices.push_back(ball.vertices[v] + geom::Vec3(wiggle, 1 - wiggle, 0) * 0.004);
    }
    soup.triangles.push_back({base, base + 1, base + 2});
  }
  const LayerStack layers = sliced(soup, 0.5);
  require_well_formed(layers);
  const LayerStack sound = sliced(ball, 0.5);
  for (std::size_t i = 0; i < layers.size(); ++i)
    CHECK(area_mm2(layers[i].regions) == Approx(area_mm2(sound[i].regions)).epsilon(0.01).margin(0.05));
}

TEST_CASE("edges shared by four facets keep both bodies") {
  // Two cubes that share one vertical edge, with common vertices.
  TriangleMesh a = test::cube(5);
  TriangleMesh b = test::moved(test::cube(5), 5, 5, 0);
  TriangleMesh both = a;
  std::vector<std::uint32_t> to(b.vertices.size());
  for (std::size_t v = 0; v < b.vertices.size(); ++v) {
    std::size_t at = 0;
    while (at < both.vertices.size() && both.vertices[at] != b.vertices[v]) ++at;
    if (at == both.vertices.size()) both.vertices.push_back(b.vertices[v]);
    to[v] = static_cast<std::uint32_t>(at);
  }
  for (const auto& t : b.triangles) both.triangles.push_back({to[t[0]], to[t[1]], to[t[2]]});
  REQUIRE(both.vertices.size() == 14);
  CHECK(area_mm2(slice_at(both, 2.5)) == 50);
}

TEST_CASE("the same bytes come out on any number of threads") {
  const TriangleMesh mesh = test::joined(test::sphere(8), test::moved(test::cup(20, 16, 12, 2, 1), 5, 5, 0));
  run::Context one;
  one.threads = 1;
  const LayerStack reference = sliced(mesh, 0.1, one);
  for (const unsigned threads : {2u, 3u, 8u}) {
    run::Context ctx;
    ctx.threads = threads;
    const LayerStack layers = sliced(mesh, 0.1, ctx);
    REQUIRE(layers.size() == reference.size());
    for (std::size_t i = 0; i < layers.size(); ++i) REQUIRE(layers[i].regions == reference[i].regions);
  }
}

TEST_CASE("one cut and the whole stack agree") {
  for (const auto& [name, mesh] : shapes()) {
    const LayerStack layers = sliced(mesh, 0.7);
    for (const Layer& l : layers) CHECK(geom::area(slice_at(mesh, l.span.cut_mm())) == geom::area(l.regions));
  }
}

TEST_CASE("resolution thins points out within its tolerance") {
  const TriangleMesh rod = test::cylinder(10, 1, 2000);
  SliceOptions coarse;
  coarse.resolution_mm = 0.01;
  const auto fine = slice_at(rod, 0.5);
  const auto thin = slice_at(rod, 0.5, coarse);
  REQUIRE(thin.size() == 1);
  CHECK(thin[0].outer.size() < fine[0].outer.size() / 8);
  CHECK(geom::subtract(fine, geom::offset(thin, 10'100)).empty());
  CHECK(geom::subtract(thin, geom::offset(fine, 100)).empty());
}

TEST_CASE("slicing tells how far it is") {
  run::Context ctx;
  std::mutex mutex;
  double last = 0;
  int reports = 0;
  ctx.on_progress = [&](std::string_view phase, double fraction) {
    const std::lock_guard lock(mutex);
    CHECK(phase == "slice");
    last = std::max(last, fraction);
    ++reports;
  };
  sliced(test::sphere(8), 0.1, ctx);
  CHECK(last == 1);
  CHECK(reports > 3);
}

TEST_CASE("slicing stops on request") {
  const auto source = std::make_unique<std::stop_source>();
  run::Context ctx;
  ctx.stop = source->get_token();
  int layers = 0;
  ctx.threads = 1;
  ctx.on_progress = [&](std::string_view, double) {
    ++layers;
    source->request_stop();
  };
  CHECK_THROWS_AS(sliced(test::sphere(8), 0.1, ctx), run::Stopped);
  CHECK(layers == 1);
}

TEST_CASE("nothing in, nothing out") {
  CHECK(slice_mesh({}, {}).empty());
  CHECK(slice_mesh({}, {{0, 0.2}})[0].regions.empty());
  CHECK(slice_at({}, 1).empty());
}

}  // namespace voidpath::slice

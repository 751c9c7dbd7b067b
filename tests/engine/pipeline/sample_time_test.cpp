#include "engine/pipeline/sample_time.h"

#include "engine/pipeline/sample_layers.h"
#include "engine/slice/layer_heights.h"
#include "engine/slice/slice_mesh.h"
#include "tests/support/meshes.h"

#include <catch2/catch.hpp>

using namespace voidpath;
using pipeline::PrepareOptions;

namespace {

const geom::Vec3 kUp = geom::Vec3::UnitZ();

slice::LayerStack cut(const mesh::TriangleMesh& mesh, double layer_mm) {
  const auto standing = mesh::turned(mesh, geom::Vec3::UnitZ());
  return slice::slice_mesh(standing,
                           slice::equal_layers(mesh::bounds(standing).size().z(), layer_mm, layer_mm));
}

struct Part {
  const char* name;
  mesh::TriangleMesh mesh;
  double off;  ///< a sample may be off by this share
};

/// Tall enough to be sampled, at 0.1 mm a layer.
std::vector<Part> parts() {
  return {{"box", test::box(12, 20, 30), 0.02},
          {"table, which needs support", test::table(30, 20, 24, 3, 4), 0.06},
          {"cup", test::cup(18, 14, 24, 2, 2), 0.03},
          {"ball", test::sphere(12, 16, 24), 0.06}};
}

PrepareOptions thin_layers() {
  PrepareOptions o;
  o.print.slice.layer_height_mm = 0.1;
  o.print.slice.first_layer_height_mm = 0.1;
  return o;
}

}  // namespace

TEST_CASE("groups cover the stack, samples lie in their groups, the first layer is alone") {
  for (const std::size_t most : {3U, 10U, 40U, 1000U}) {
    const auto stack = cut(test::table(30, 20, 24, 3, 4), 0.1);
    const auto groups = pipeline::choose_samples(stack, {}, most);
    CAPTURE(most);
    REQUIRE_FALSE(groups.empty());
    CHECK(groups.size() <= most);
    CHECK(groups.front().count == 1);
    std::size_t next = 0;
    for (const auto& g : groups) {
      CHECK(g.first == next);
      CHECK(g.count > 0);
      CHECK(g.sample >= g.first);
      CHECK(g.sample < g.first + g.count);
      next += g.count;
    }
    CHECK(next == stack.size());
  }
}

TEST_CASE("groups are cut where the area jumps") {
  const auto stack = cut(test::table(30, 20, 24, 3, 4), 0.1);  // the slab begins at 21 mm
  const auto groups = pipeline::choose_samples(stack, {}, 20);
  std::size_t slab = 0;
  while (geom::area(stack[slab].regions) < 2 * geom::area(stack[10].regions)) ++slab;
  bool cut_there = false;
  for (const auto& g : groups) cut_there = cut_there || g.first == slab;
  CHECK(cut_there);
}

TEST_CASE("a sample of layers tells the time of the print") {
  const PrepareOptions o = thin_layers();
  for (const Part& part : parts()) {
    CAPTURE(part.name);
    const auto sampled = pipeline::sample_time(part.mesh, kUp, o, {});
    CHECK(sampled.planned < sampled.layers / 2);
    const double full = pipeline::time_part(part.mesh, kUp, o, {});
    CHECK(sampled.seconds == Approx(full).epsilon(part.off));
  }
}

TEST_CASE("a part of few layers is timed in full at once") {
  const PrepareOptions o;
  const auto mesh = test::box(12, 20, 4);
  const auto sampled = pipeline::sample_time(mesh, kUp, o, {});
  CHECK(sampled.planned == sampled.layers);
  CHECK(sampled.seconds == pipeline::time_part(mesh, kUp, o, {}));
}

TEST_CASE("a sample does not depend on the number of threads") {
  const PrepareOptions o = thin_layers();
  const auto mesh = test::table(30, 20, 24, 3, 4);
  run::Context one, many;
  one.threads = 1;
  many.threads = 4;
  CHECK(pipeline::sample_time(mesh, kUp, o, one).seconds ==
        pipeline::sample_time(mesh, kUp, o, many).seconds);
}

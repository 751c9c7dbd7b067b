#include "tests/engine/mesh/import_support.h"
#include "tests/support/meshes.h"
#include "tests/support/real_models.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>

#include <catch2/catch.hpp>
#include <sys/resource.h>

using namespace voidpath;
using Catch::Contains;

namespace {

double number(const std::string& text) {
  double value = std::nan("");
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

/// The folder of the shared corpus; empty, after a warning, when there is none.
std::filesystem::path corpus(const char* name) {
  if (test::shared_dir().empty()) {
    WARN("VOIDPATH_SHARED is not set: the corpus of models is not tested");
    return {};
  }
  return std::filesystem::path(test::shared_dir()) / name;
}

long peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

void check_repaired(const mesh::Import& got) {
  mesh::TriangleMesh again = got.mesh;
  CHECK_FALSE(mesh::repair(again).changed());
  CHECK(again.triangles == got.mesh.triangles);
  CHECK(mesh::volume(got.mesh) > 0);
  CHECK(std::all_of(got.mesh.vertices.begin(), got.mesh.vertices.end(),
                    [](const mesh::Vec3& v) { return v.allFinite(); }));
  CHECK(std::all_of(got.mesh.triangles.begin(), got.mesh.triangles.end(), [&](const mesh::Triangle& t) {
    return std::max({t[0], t[1], t[2]}) < got.mesh.vertices.size();
  }));
}

}  // namespace

TEST_CASE("Every good model measures what its manifest says and is left as it is") {
  const auto folder = corpus("models");
  if (folder.empty()) return;
  std::size_t checked = 0;
  for (auto& row : test::read_csv(folder / "MANIFEST.csv")) {
    if (row["format"] == "amf") continue;
    INFO(row["file"]);
    mesh::ImportOptions options;
    options.scale = number(row["scale"]);
    const mesh::Import got = mesh::import_model(folder / row["file"], options);
    const mesh::MeshReport& r = got.delivered;
    CHECK(r.triangles == static_cast<std::size_t>(number(row["triangles"])));
    // Five digits are given.
    CHECK(r.size_mm.x() == Approx(options.scale * number(row["size_x"])).epsilon(1e-4));
    CHECK(r.size_mm.y() == Approx(options.scale * number(row["size_y"])).epsilon(1e-4));
    CHECK(r.size_mm.z() == Approx(options.scale * number(row["size_z"])).epsilon(1e-4));
    CHECK(r.volume_mm3 == Approx(std::pow(options.scale, 3) * number(row["volume"])).epsilon(1e-4));
    CHECK(r.shells == static_cast<std::size_t>(number(row["shells"])));
    CHECK(r.non_manifold_edges == static_cast<std::size_t>(number(row["nonmanifold_edges"])));
    CHECK(r.watertight());
    CHECK(r.flipped_faces == 0);
    CHECK(mesh::volume(got.mesh) == Approx(r.volume_mm3));
    // Some hold facets with a corner used twice, which go; nothing else may change.
    mesh::RepairReport other = got.repairs;
    other.degenerate_removed = 0;
    CHECK_FALSE(other.changed());
    check_repaired(got);
    ++checked;
  }
  CHECK(checked == 76);
}

TEST_CASE("Every bad model ends as its manifest says") {
  const auto folder = corpus("bad-models");
  if (folder.empty()) return;
  std::size_t checked = 0;
  for (auto& row : test::read_csv(folder / "MANIFEST.csv")) {
    const std::string& expected = row["expected"];
    INFO(row["file"] << ": " << row["defect"] << ", expected: " << expected);
    const auto begin = std::chrono::steady_clock::now();
    try {
      const mesh::Import got = mesh::import_model(folder / row["file"]);
      CHECK(expected != "reject");
      check_repaired(got);
      if (expected == "accept") {
        CHECK_FALSE(got.repairs.changed());
        CHECK(got.delivered.watertight());
      }
      if (expected == "repair") {
        CHECK(got.repairs.changed());
        // What cannot be closed is little beside what is there.
        CHECK(5 * got.repairs.open_edges_left < 3 * got.mesh.triangles.size());
      }
    } catch (const mesh::ImportError& e) {
      INFO(e.what());
      CHECK_THAT(expected, Contains("reject"));
      CHECK_THAT(e.what(), Contains(row["file"] + ": "));
      CHECK(std::string(e.what()).size() > row["file"].size() + 12);
    }
    CHECK(std::chrono::steady_clock::now() - begin < std::chrono::seconds(60));
    ++checked;
  }
  CHECK(checked == 87);
  CHECK(peak_kb() < 1'000'000);
}

TEST_CASE("Damage done to a good model is undone") {
  const auto folder = corpus("bad-models");
  if (folder.empty()) return;
  const double volume = mesh::volume(mesh::import_model(corpus("models") / "mendel90__z_coupling.stl").mesh);
  for (const char* name : {"made__inverted_all.stl", "made__inverted_30pct.stl", "made__missing_5_facets.stl",
                           "made__jitter_open.stl", "made__duplicate_facets.stl", "made__nan_vertex.stl"}) {
    INFO(name);
    const mesh::Import got = mesh::import_model(folder / name);
    CHECK(mesh::volume(got.mesh) == Approx(volume).epsilon(1e-3));
    const mesh::MeshReport after = mesh::inspect(got.mesh);
    CHECK(after.watertight());
    CHECK(after.shells == 1);
    CHECK(after.triangles == 724);
  }
}

TEST_CASE("Gaps between sides that only just miss each other are closed") {
  const auto folder = corpus("bad-models");
  if (folder.empty()) return;
  for (const char* name : {"real__bcn3d-moveo__Servo_Gear.stl", "real__bcn3d-moveo__2M2M.stl",
                           "real__bcn3d-moveo__Gripper_Left.stl", "real__trimesh__featuretype.stl",
                           "real__trimesh__angle_block.stl", "real__slic3r__spikey_top.stl",
                           "real__opensls__idler_mount.stl", "real__superslicer__frog_legs.obj"}) {
    INFO(name);
    const mesh::Import got = mesh::import_model(folder / name);
    CHECK(mesh::inspect(got.mesh).watertight());
    CHECK(got.repairs.holes_filled == 0);
    CHECK(mesh::volume(got.mesh) == Approx(got.delivered.volume_mm3).epsilon(1e-4));
  }
}

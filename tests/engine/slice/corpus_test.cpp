#include "engine/geom/polygon_ops.h"
#include "engine/mesh/import.h"
#include "engine/slice/slice_mesh.h"
#include "tests/support/meshes.h"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

/// Laws on real parts; needs the shared test material.
namespace voidpath::slice {

namespace {

namespace fs = std::filesystem;

/// Cuts are many enough that what they miss between them stays below the tolerances used here.
constexpr int kPlanes = 300;

std::vector<fs::path> files_in(const std::string& folder) {
  std::vector<fs::path> files;
  const fs::path dir = fs::path(test::shared_dir()) / folder;
  if (test::shared_dir().empty() || !fs::is_directory(dir)) {
    WARN("skipped: VOIDPATH_SHARED has no " << folder);
    return files;
  }
  for (const auto& entry : fs::directory_iterator(dir))
    if (mesh::is_model_name(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

LayerStack sliced(const mesh::TriangleMesh& mesh) {
  const double height = mesh::bounds(mesh).max.z();
  std::vector<LayerSpan> spans;
  for (int i = 0; i < kPlanes; ++i) spans.push_back({height * i / kPlanes, height * (i + 1) / kPlanes});
  return slice_mesh(mesh, spans);
}

double volume_of(const LayerStack& layers) {
  double sum = 0;
  for (const Layer& l : layers) sum += geom::to_mm2(geom::area(l.regions)) * l.span.height_mm();
  return sum;
}

void require_well_formed(const LayerStack& layers) {
  for (const Layer& l : layers)
    for (const geom::Region& r : l.regions) {
      REQUIRE(r.outer.size() >= 3);
      REQUIRE(geom::area(r.outer) > 0);
      for (const geom::Ring& hole : r.holes) REQUIRE(geom::area(hole) < 0);
    }
}

}  // namespace

TEST_CASE("real parts keep their volume, standing and tilted", "[corpus]") {
  for (const fs::path& file : files_in("models")) {
    INFO(file.filename().string());
    const mesh::TriangleMesh mesh = mesh::import_model(file).mesh;
    const double volume = mesh::volume(mesh);
    const LayerStack standing = sliced(mesh::turned(mesh, geom::Vec3::UnitZ()));
    require_well_formed(standing);
    // Faces parallel to the planes fall between two of them: a layer's worth of area either way.
    CHECK(volume_of(standing) == Approx(volume).epsilon(0.03));
    const LayerStack tilted = sliced(mesh::turned(mesh, geom::Vec3(1, 2, 3).normalized()));
    require_well_formed(tilted);
    // Overlapping bodies count twice in the mesh's volume, once in the layers.
    CHECK(volume_of(tilted) == Approx(volume).epsilon(0.004));
  }
}

TEST_CASE("damaged parts that are let in give layers of about their volume", "[corpus]") {
  for (const fs::path& file : files_in("bad-models")) {
    INFO(file.filename().string());
    mesh::Import import;
    try {
      import = mesh::import_model(file);
    } catch (const mesh::ImportError&) {
      continue;
    }
    const LayerStack layers = sliced(mesh::turned(import.mesh, geom::Vec3(1, 2, 3).normalized()));
    require_well_formed(layers);
    const double volume = mesh::volume(import.mesh);
    // Overlaps count twice in the volume; an open edge is closed by a straight line in each layer.
    CHECK(volume_of(layers) == Approx(volume).epsilon(0.2));
  }
}

}  // namespace voidpath::slice

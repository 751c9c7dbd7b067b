#include "engine/orient/trapped_volume.h"

#include "engine/mesh/import.h"
#include "engine/orient/directions.h"
#include "tests/engine/orient/trapped_reference.h"
#include "tests/support/meshes.h"
#include "tests/support/real_models.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <string_view>

#include <catch2/catch.hpp>

namespace voidpath::test {

namespace {

using geom::Vec3;
using mesh::TriangleMesh;

/// Errors as shares of what V may be off by: 1 % of it or 0.5 % of the smaller of the boxes around the part,
/// as it lies in its file and as seen along the line.
struct Errors {
  double worst = 0;
  double squares = 0;
  double reference = 0;  ///< how much the reference disagrees with itself, at most
  Vec3 at = Vec3::Zero();
  std::size_t count = 0;
};

Errors errors_of(const TriangleMesh& m, const std::vector<Vec3>& directions, int lines) {
  const orient::Solid solid = orient::prepare_solid(m, {});
  orient::TrappedVolumeRaster raster(solid);
  orient::Projection p;
  Errors out;
  for (const Vec3& d : directions) {
    orient::project(solid, d, p);
    const orient::TrappedVolume v = raster.measure(p);
    const TrappedReference r = trapped_reference(m, d, lines);
    const double seen = (p.x_max - p.x_min) * (p.y_max - p.y_min) * (p.h_max - p.h_min);
    const double of_box = 0.005 * std::min(seen, mesh::bounds(m).size().prod());
    for (const auto& [got, want] : {std::pair(v.up_mm3, r.up_mm3), std::pair(v.down_mm3, r.down_mm3)}) {
      const double allowed = std::max(0.01 * want, of_box);
      const double error = std::abs(got - want) / allowed;
      if (error >= out.worst) {
        out.worst = error;
        out.at = d;
      }
      out.squares += error * error;
      out.reference = std::max(out.reference, r.off_mm3 / allowed);
      ++out.count;
    }
  }
  return out;
}

/// Directions spread at random, the same each time.
std::vector<Vec3> random_directions(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> within(-1, 1);
  std::vector<Vec3> out;
  while (out.size() < static_cast<std::size_t>(count)) {
    const double x = within(random);
    const double y = within(random);
    const double z = within(random);
    const Vec3 v(x, y, z);
    if (v.norm() <= 1 && v.norm() > 0.1) out.push_back(v.normalized());
  }
  return out;
}

/// A card of ridges that run along y.
TriangleMesh ridged_card(int ridges, double ridge, double gap, double length) {
  TriangleMesh m = comb(ridges, ridge, gap, 0.8, 0.8);
  for (Vec3& v : m.vertices) v.y() *= length / ridge;
  return m;
}

}  // namespace

TEST_CASE("V of parts that repeat themselves is within its bound, whatever the line of sight") {
  std::vector<Vec3> lines = orient::icosphere_directions(1);
  std::erase_if(lines, [](const Vec3& d) { return !orient::is_canonical(d); });  // both ways come out of one
  // Rows 1/64 of the part apart, slanted the same for every part, run along the ridges.
  lines.insert(lines.end(), {Vec3(0.5843, 0.1588, 0.7959), Vec3(-0.8852, 0.4369, 0.1599)});
  for (Vec3& d : lines) d.normalize();
  const TriangleMesh shapes[] = {
      ridged_card(38, 0.6, 1, 84), ridged_card(20, 1, 2, 60), comb(30, 2, 1.2, 15, 3),
      joined(ridged_card(12, 1, 4, 60), moved(ridged_card(12, 1, 4, 60), 0, 0, 5))};
  for (const TriangleMesh& m : shapes) {
    const Errors e = errors_of(m, lines, 400);
    INFO(m.triangles.size() << " triangles, along " << e.at.transpose());
    CHECK(e.reference < 1);  // or it tells nothing
    CHECK(e.worst < 1);
  }
}

TEST_CASE("V of real parts is within its bound where rows met with a pattern") {
  if (shared_dir().empty()) {
    WARN("VOIDPATH_SHARED is not set: skipped");
    return;
  }
  std::vector<Vec3> lines = random_directions(8);
  for (const Vec3& d : {Vec3(0.544, 0.235, 0.806), Vec3(0.470, 0.236, 0.850)})
    lines.push_back(d.normalized());
  for (const char* name :
       {"3d-printing__Monatskarten_euro-arabisch.stl", "stl-to-voxel__Menger_sponge_sample.stl",
        "rpg-scad__abacus.stl", "calibration-shapes__TempTowerPLA.stl"}) {
    const TriangleMesh m = mesh::import_model(std::filesystem::path(shared_dir()) / "models" / name).mesh;
    const Errors e = errors_of(m, lines, 700);
    INFO(name << " along " << e.at.transpose());
    CHECK(e.reference < 0.5);
    CHECK(e.worst < 1);
  }
}

/// $VOIDPATH_LINES lines, or 40, through every model whose name holds $VOIDPATH_ONLY.
TEST_CASE("V of every real part is within its bound", "[.every]") {
  const char* only = std::getenv("VOIDPATH_ONLY");
  const std::string_view asked =
      std::getenv("VOIDPATH_LINES") != nullptr ? std::getenv("VOIDPATH_LINES") : "";
  int count = 40;
  std::from_chars(asked.data(), asked.data() + asked.size(), count);
  const std::vector<Vec3> lines = random_directions(count);
  const auto models =
      real_models(std::filesystem::path(shared_dir()) / "models", only != nullptr ? only : "");
  CHECK(!models.empty());
  std::printf("%-62s %7s %7s %9s   of what V may be off by, both ways along %d lines\n", "part", "worst",
              "rms", "reference", count);
  for (const RealModel& model : models) {
    const std::string name = model.file.filename().string();
    const Errors e = errors_of(mesh::import_model(model.file).mesh, lines, 800);
    std::printf("%-62s %7.3f %7.3f %9.3f\n", name.c_str(), e.worst,
                std::sqrt(e.squares / static_cast<double>(e.count)), e.reference);
    std::fflush(stdout);
    INFO(name << " along " << e.at.transpose());
    CHECK(e.worst < 1);
  }
}

}  // namespace voidpath::test

#include "engine/mesh/import.h"
#include "engine/orient/search.h"
#include "tests/engine/orient/reference.h"
#include "tests/support/meshes.h"

#include <cmath>
#include <filesystem>

#include <catch2/catch.hpp>

namespace voidpath::test {

using geom::Vec3;

namespace {

/// Sound meshes, some with many regions, some with cavities, some round; small enough for the plain
/// reference.
const char* const kModels[] = {"calibration-shapes__HollowCalibrationCube.stl",
                               "dotscad_drilled_cube.stl",
                               "dotscad_fidget_star.stl",
                               "dotscad_soccer_polyhedron.stl",
                               "mendel90__small_bits.stl",
                               "mendel90__spool_bracket_male.stl",
                               "original-prusa-i3__LCD-cover-ORIGINAL-MK3.stl",
                               "original-prusa-i3__x-end-motor.stl",
                               "prusaslicer__bunny.stl",
                               "rpg-scad__comb_13.stl",
                               "rpg-scad__snake.stl",
                               "stl-to-voxel__Menger_sponge_sample.stl"};

}  // namespace

TEST_CASE("real parts agree with the reference") {
  if (shared_dir().empty()) {
    WARN("VOIDPATH_SHARED is not set: skipped");
    return;
  }
  const Vec3 directions[] = {Vec3(0.31, -0.52, 0.79).normalized(), Vec3(-0.66, 0.21, -0.43).normalized(),
                             Vec3::UnitZ(), -Vec3::UnitX()};
  for (const char* name : kModels) {
    const mesh::TriangleMesh m =
        mesh::import_model(std::filesystem::path(shared_dir()) / "models" / name).mesh;
    for (const Vec3& d : directions) {
      INFO(name << " along " << d.transpose());
      const orient::Criteria c = orient::evaluate(m, {d}, {}).at(0);
      const orient::Criteria r = reference_criteria(m, d);
      CHECK(c.height_mm == Approx(r.height_mm).epsilon(1e-9));
      CHECK(c.contours == Approx(r.contours).epsilon(1e-6));
      CHECK(c.void_mm == Approx(r.void_mm).epsilon(1e-5).margin(1e-6));
      CHECK(std::abs(c.trapped_mm3 - r.trapped_mm3) <=
            std::max(0.01 * r.trapped_mm3, 0.005 * bounding_volume(m, d)));
    }
  }
}

}  // namespace voidpath::test

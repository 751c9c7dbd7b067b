#include "engine/pipeline/prepare.h"

#include "engine/gcode/estimate.h"
#include "engine/mesh/write.h"
#include "engine/pipeline/slice_part.h"
#include "tests/support/meshes.h"

#include <cstdlib>
#include <fstream>

#include <catch2/catch.hpp>
#include <unistd.h>

using namespace voidpath;
namespace fs = std::filesystem;

namespace {

/// A folder of its own, gone at the end.
class Folder {
 public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "voidpath-prepare-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  fs::path model(const mesh::TriangleMesh& mesh) const {
    mesh::write_model(mesh, path_ / "part.stl");
    return path_ / "part.stl";
  }
  fs::path gcode() const { return path_ / "part.gcode"; }
  std::size_t count() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
  }

 private:
  fs::path path_;
};

pipeline::PrepareOptions quick_options() {
  pipeline::PrepareOptions o;
  o.orient.subdivisions = 1;
  o.print.slice.layer_height_mm = 0.4;
  o.print.slice.first_layer_height_mm = 0.4;
  return o;
}

}  // namespace

TEST_CASE("a forced direction is printed, and compared with as delivered") {
  const Folder folder;
  auto o = quick_options();
  o.direction = geom::Vec3(3, 0, 0);
  const auto p = pipeline::prepare(folder.model(test::box(8, 12, 30)), folder.gcode(), o, true);
  const auto& chosen = p.choice.candidates[p.choice.chosen];
  CHECK(chosen.direction == geom::Vec3::UnitX());
  CHECK(chosen.criteria.height_mm == Approx(8));
  CHECK(p.stats.layers == 20);
  REQUIRE(p.as_delivered_s);
  CHECK(*p.as_delivered_s == pipeline::time_part(p.model.mesh, geom::Vec3(0, 0, 1), o, {}));
  CHECK(*p.as_delivered_s > p.estimate.predicted_s);
  CHECK(folder.count() == 2);  // the model and the G-code
  // What was predicted is what the file takes.
  CHECK(gcode::estimate_file(folder.gcode(), o.limits).predicted_s == p.estimate.predicted_s);
}

TEST_CASE("a prepared part is the quickest of what was timed") {
  const Folder folder;
  const auto o = quick_options();
  const auto p = pipeline::prepare(folder.model(test::table(30, 20, 24, 3, 4)), folder.gcode(), o, true);
  for (const auto& [name, i] : p.choice.baselines) {
    CAPTURE(name);
    CHECK(p.estimate.predicted_s <= p.choice.candidates[i].predicted_s.value_or(1e300));
  }
  REQUIRE(p.as_delivered_s);
  CHECK(p.as_delivered_s == p.choice.candidates[p.choice.as_delivered].predicted_s);
}

TEST_CASE("what does not fit is refused and leaves nothing behind") {
  const Folder folder;
  auto o = quick_options();
  const auto model = folder.model(test::box(30, 30, 260));
  o.direction = geom::Vec3::UnitZ();
  CHECK_THROWS_AS(pipeline::prepare(model, folder.gcode(), o, false), pipeline::Refused);
  CHECK(folder.count() == 1);
  // Lying down it does not fit either; nor does leaning.
  o.direction.reset();
  CHECK_THROWS_AS(pipeline::prepare(folder.model(test::box(300, 300, 300)), folder.gcode(), o, false),
                  orient::NothingFits);
  CHECK(folder.count() == 1);
}

TEST_CASE("stopping half-way leaves nothing behind") {
  const Folder folder;
  const auto model = folder.model(test::box(20, 20, 20));
  auto o = quick_options();
  o.direction = geom::Vec3::UnitZ();
  std::stop_source stop;
  run::Context ctx;
  ctx.stop = stop.get_token();
  ctx.on_progress = [&](std::string_view phase, double) {
    if (phase == "slice") stop.request_stop();
  };
  CHECK_THROWS_AS(pipeline::prepare(model, folder.gcode(), o, false, ctx), run::Stopped);
  CHECK(folder.count() == 1);
}

TEST_CASE("a place that cannot be written is named") {
  const Folder folder;
  const auto model = folder.model(test::box(20, 20, 20));
  auto o = quick_options();
  o.direction = geom::Vec3::UnitZ();
  const fs::path nowhere = folder.gcode() / "missing" / "part.gcode";
  CHECK_THROWS_WITH(pipeline::prepare(model, nowhere, o, false), Catch::Contains(nowhere.string()));
}

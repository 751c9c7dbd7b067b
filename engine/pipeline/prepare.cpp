#include "engine/pipeline/prepare.h"

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <unistd.h>

#include "engine/pipeline/bed_fit.h"
#include "engine/slice/layer_heights.h"
#include "engine/slice/slice_mesh.h"
#include "engine/toolpath/build.h"

namespace voidpath::pipeline {

namespace fs = std::filesystem;

namespace {

std::string one_decimal(double v) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.1f", v);
  return buffer;
}

std::string size_text(const geom::Vec3& size) {
  return one_decimal(size.x()) + " x " + one_decimal(size.y()) + " x " + one_decimal(size.z()) + " mm";
}

/// Width of what is laid around the part on the first layer.
double surround_mm(const toolpath::SliceSettings& s) {
  const double skirt = s.skirt_loops > 0 ? s.skirt_gap_mm + s.skirt_loops * s.first_layer_line_width_mm : 0;
  return s.brim_width_mm + skirt;
}

struct Placed {
  mesh::TriangleMesh mesh;
  toolpath::PrintSettings print;
};

/// The part standing in `direction`, turned about z so that it fits. The skirt is left off where only the
/// part itself fits; anything larger is refused.
Placed place(const mesh::TriangleMesh& mesh, const geom::Vec3& direction, const PrepareOptions& options) {
  Placed placed{mesh::turned(mesh, direction), options.print};
  const auto& machine = options.print.machine;
  const geom::Vec3 size = mesh::bounds(placed.mesh).size();
  const auto refuse = [&] {
    return Refused("the part is " + size_text(size) + " in this orientation and does not fit the printer's " +
                   one_decimal(machine.bed_mm[0]) + " x " + one_decimal(machine.bed_mm[1]) + " x " +
                   one_decimal(machine.height_mm) + " mm; scale it down or choose another printer");
  };
  if (size.z() > machine.height_mm + 1e-6) throw refuse();
  auto turn = bed_turn(placed.mesh, machine.bed_mm, surround_mm(placed.print.slice));
  if (!turn) {
    placed.print.slice.skirt_loops = 0;
    turn = bed_turn(placed.mesh, machine.bed_mm, placed.print.slice.brim_width_mm);
  }
  if (!turn) throw refuse();
  placed.mesh = turned_about_z(placed.mesh, *turn);
  return placed;
}

struct Sliced {
  toolpath::EmitStats stats;
  gcode::Estimate estimate;
};

/// Temporary beside the target, renamed into place by commit(), gone otherwise.
class AtomicFile {
 public:
  explicit AtomicFile(fs::path target) : target_(std::move(target)), part_(target_.string() + ".part") {
    out_.open(part_, std::ios::binary | std::ios::trunc);
    if (!out_) throw error("cannot be written");
  }
  ~AtomicFile() {
    std::error_code ec;
    if (!committed_) fs::remove(part_, ec);
  }
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  std::ostream& stream() { return out_; }
  const fs::path& path() const { return part_; }
  void close() {
    out_.close();
    if (!out_) throw error("writing failed (is the disk full?)");
    const int fd = ::open(part_.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd >= 0) {
      ::fsync(fd);
      ::close(fd);
    }
  }
  void commit() {
    std::error_code ec;
    fs::rename(part_, target_, ec);
    if (ec) throw std::runtime_error(target_.string() + ": cannot be put in place: " + ec.message());
    committed_ = true;
  }

 private:
  std::runtime_error error(const std::string& what) const {
    return std::runtime_error(target_.string() + ": " + what + (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
  }
  fs::path target_;
  fs::path part_;
  std::ofstream out_;
  bool committed_ = false;
};

Sliced slice_to(const mesh::TriangleMesh& mesh, const geom::Vec3& direction, const PrepareOptions& options,
                const fs::path& out, const run::Context& ctx) {
  const Placed placed = place(mesh, direction, options);
  const auto& s = placed.print.slice;
  const double height = mesh::bounds(placed.mesh).size().z();
  ctx.progress("slice", 0.0);
  auto stack = slice::slice_mesh(placed.mesh, slice::equal_layers(height, s.first_layer_height_mm, s.layer_height_mm),
                                 {}, ctx);
  toolpath::place_on_bed(stack, placed.print.machine);
  const toolpath::Plan plan = toolpath::build(stack, placed.print, ctx);
  if (plan.layers.empty()) throw Refused("nothing is left to print: the part is thinner than a line everywhere");
  Sliced sliced;
  AtomicFile file(out);
  const geom::Vec3 d = direction;
  const std::string header = "direction " + std::to_string(d.x()) + " " + std::to_string(d.y()) + " " +
                             std::to_string(d.z());
  sliced.stats = toolpath::emit(plan, placed.print, header, file.stream(), ctx);
  file.close();
  sliced.estimate = gcode::estimate_file(file.path(), options.limits, ctx);
  file.commit();
  return sliced;
}

orient::Choice forced(const mesh::TriangleMesh& mesh, const geom::Vec3& direction, const PrepareOptions& options,
                      const run::Context& ctx) {
  orient::Choice choice;
  const std::vector<geom::Vec3> directions = {geom::Vec3::UnitZ(), direction.normalized()};
  const auto criteria = orient::evaluate(mesh, directions, options.orient, ctx);
  for (std::size_t i = 0; i < directions.size(); ++i) {
    orient::Candidate c;
    c.direction = directions[i];
    c.origin = i == 0 ? orient::Origin::as_delivered : orient::Origin::sampled;
    c.criteria = criteria[i];
    choice.candidates.push_back(c);
  }
  choice.as_delivered = 0;
  choice.chosen = 1;
  choice.ties = {1};
  choice.weights = options.orient.weights;
  choice.method = options.orient.method;
  choice.why = "the direction was given";
  return choice;
}

}  // namespace

orient::Choice choose(const mesh::TriangleMesh& mesh, const PrepareOptions& options, const run::Context& ctx) {
  if (options.direction) return forced(mesh, *options.direction, options, ctx);
  return orient::search(mesh, options.orient, ctx);
}

Prepared prepare(const fs::path& model, const fs::path& gcode_out, const PrepareOptions& options, bool compare,
                 const run::Context& ctx) {
  Prepared p;
  ctx.progress("import", 0.0);
  p.model = mesh::import_model(model, options.import, ctx);
  p.choice = choose(p.model.mesh, options, ctx);

  auto& chosen = p.choice.candidates[p.choice.chosen];
  Sliced sliced = slice_to(p.model.mesh, chosen.direction, options, gcode_out, ctx);
  p.stats = sliced.stats;
  p.estimate = std::move(sliced.estimate);
  chosen.predicted_s = p.estimate.predicted_s;

  auto& delivered = p.choice.candidates[p.choice.as_delivered];
  if (!compare || p.choice.as_delivered == p.choice.chosen) return p;
  try {
    const fs::path scratch = gcode_out.string() + ".as-delivered";
    p.as_delivered = slice_to(p.model.mesh, delivered.direction, options, scratch, ctx).estimate;
    std::error_code ec;
    fs::remove(scratch, ec);
    delivered.predicted_s = p.as_delivered->predicted_s;
  } catch (const Refused&) {
    // As delivered it does not fit: there is nothing to compare with.
  }
  return p;
}

}  // namespace voidpath::pipeline

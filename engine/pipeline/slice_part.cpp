#include "engine/pipeline/slice_part.h"

#include "engine/gcode/progress.h"
#include "engine/gcode/timed_stream.h"
#include "engine/orient/feasible.h"
#include "engine/orient/words.h"
#include "engine/pipeline/foreign.h"
#include "engine/render/thumbnail.h"
#include "engine/slice/adaptive_layers.h"
#include "engine/slice/layer_heights.h"
#include "engine/slice/slice_mesh.h"
#include "engine/toolpath/adhesion/raft.h"
#include "engine/toolpath/build.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <future>
#include <memory>
#include <numbers>
#include <sstream>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace voidpath::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr double kHoldingBrim_mm = 5;

std::string size_text(double x, double y, double z) {
  return orient::number(x, 1) + " x " + orient::number(y, 1) + " x " + orient::number(z, 1) + " mm";
}

/// What is laid right around the part on the first layer, brim or raft.
double collar_mm(const toolpath::SliceSettings& s) {
  if (s.raft_layers > 0) return s.raft_margin_mm;
  return s.brim_width_mm > 0 && s.brim_type != toolpath::BrimType::inner ? s.brim_width_mm + s.brim_gap_mm
                                                                         : 0;
}

/// Width of the skirt beyond that.
double skirt_mm(const toolpath::SliceSettings& s) {
  return s.skirt_loops > 0 ? s.skirt_gap_mm + s.skirt_loops * s.first_layer_line_width_mm : 0;
}

mesh::TriangleMesh turned_about_z(mesh::TriangleMesh mesh, double angle) {
  if (angle == 0) return mesh;
  mesh = mesh::rotated(mesh, geom::Quaternion(Eigen::AngleAxisd(angle, geom::Vec3::UnitZ())));
  const mesh::Bounds b = mesh::bounds(mesh);
  const geom::Vec3 shift(-0.5 * (b.min.x() + b.max.x()), -0.5 * (b.min.y() + b.max.y()), 0);
  for (auto& v : mesh.vertices) v += shift;
  return mesh;
}

struct Placed {
  mesh::TriangleMesh mesh;
  toolpath::PrintSettings print;
};

std::string turn_text(double turn_rad) {
  return turn_rad == 0 ? ""
                       : "; turned about the build axis by " +
                             orient::number(turn_rad * 180 / std::numbers::pi, 1) + " degrees";
}

/// A part exactly as large as the printer fits, whatever rounding did to it. mm
constexpr double kRounding_mm = 1e-6;

/// The turn about the build axis that makes it fit, the one asked for or, where none is, any. Nothing when it
/// does not fit.
std::optional<double> fitting_turn(const mesh::TriangleMesh& mesh, const Placed& placed, const Pose& pose,
                                   const orient::PrintLimits& limits) {
  if (pose.turn_rad == 0) return orient::bed_turn(mesh, pose.direction, limits);
  const geom::Vec3 size = mesh::bounds(placed.mesh).size();
  for (int a = 0; a < 2; ++a)
    if (size[a] + 2 * limits.bed_margin_mm > limits.volume_mm[static_cast<std::size_t>(a)] + kRounding_mm)
      return std::nullopt;
  return 0;  // turned already
}

Placed place(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options) {
  Placed placed{turned_about_z(mesh::turned(mesh, pose.direction), pose.turn_rad), options.print};
  const auto& machine = options.print.machine;
  auto& slice = placed.print.slice;
  const geom::Vec3 size = mesh::bounds(placed.mesh).size();
  orient::PrintLimits limits;
  limits.volume_mm = {machine.bed_mm[0], machine.bed_mm[1], machine.height_mm};
  limits.bed_margin_mm = collar_mm(slice) + skirt_mm(slice);
  auto turn = fitting_turn(mesh, placed, pose, limits);
  if (!turn) {
    slice.skirt_loops = 0;
    limits.bed_margin_mm = collar_mm(slice);
    turn = fitting_turn(mesh, placed, pose, limits);
  }
  if (!turn || size.z() + toolpath::raft_lift_mm(slice) > machine.height_mm + kRounding_mm)
    throw Refused("the part is " + size_text(size.x(), size.y(), size.z()) +
                  " in this orientation and does not fit the printer's " +
                  size_text(machine.bed_mm[0], machine.bed_mm[1], machine.height_mm) +
                  "; scale it down or choose another printer");
  placed.mesh = turned_about_z(std::move(placed.mesh), *turn);
  return placed;
}

/// Comment lines, drawn beside whatever else is done where there are threads for it. The part outlives them.
std::future<std::string> thumbnails(const CutPart& placed, const run::Context& ctx) {
  const auto when =
      ctx.thread_count() > 1 ? std::launch::async | std::launch::deferred : std::launch::deferred;
  return std::async(when, [&placed, &ctx] {
    std::string out;
    for (const std::string& text : placed.print.machine.thumbnails) {
      const auto [width, height] = render::picture_size(text);
      out += "\n\n" + render::thumbnail(render::draw(placed.mesh, width, height, ctx));
    }
    return out;
  });
}

/// A stream to `to` that times what passes, where there is a thread for it.
std::unique_ptr<gcode::TimedStream> timed_stream(std::ostream& to, const motion::MachineLimits& limits,
                                                 const run::Context& ctx) {
  try {
    if (ctx.thread_count() > 1) return std::make_unique<gcode::TimedStream>(to, limits, ctx);
  } catch (const std::system_error&) {
    // No thread is to be had: the file is read again.
  }
  return nullptr;
}

/// The time in the words that print hosts and viewers look for.
std::string time_comment(double seconds) {
  std::string out;
  auto left = std::llround(seconds);
  for (const auto& [name, length] : {std::pair{"d", 86400LL}, {"h", 3600LL}, {"m", 60LL}, {"s", 1LL}}) {
    if (out.empty() && left < length && length > 1) continue;
    out += " " + std::to_string(left / length) + name;
    left %= length;
  }
  return "; estimated printing time (normal mode) =" + out;
}

std::vector<slice::LayerSpan> layer_spans(const mesh::TriangleMesh& mesh, const toolpath::SliceSettings& s,
                                          const run::Context& ctx) {
  const double first = s.raft_layers > 0 ? s.layer_height_mm : s.first_layer_height_mm;
  if (s.adaptive_layers)
    return slice::adaptive_layers(
        mesh, {first, s.min_layer_height_mm, s.max_layer_height_mm, s.adaptive_error_mm}, ctx);
  return slice::equal_layers(mesh::bounds(mesh).size().z(), first, s.layer_height_mm);
}

/// Temporary beside the target, renamed into place by commit(), gone otherwise.
class AtomicFile {
 public:
  explicit AtomicFile(fs::path target) : target_(std::move(target)), part_(target_.string() + ".part") {
    out_.open(part_, std::ios::binary | std::ios::trunc);
    if (!out_) throw failure("cannot be written");
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
    if (!out_) throw failure("writing failed");
  }
  /// A line more, after close().
  void append(const std::string& line) {
    out_.open(part_, std::ios::binary | std::ios::app);
    out_ << line << '\n';
    close();
  }
  /// On disk, not just handed to the kernel, after close().
  void sync() const {
    const int fd = ::open(part_.c_str(), O_RDONLY | O_CLOEXEC);
    const bool safe = fd >= 0 && ::fsync(fd) == 0;
    const std::runtime_error error = failure("writing failed");
    if (fd >= 0) ::close(fd);
    if (!safe) throw error;
  }
  void commit() {
    std::error_code ec;
    fs::rename(part_, target_, ec);
    if (ec) throw std::runtime_error(target_.string() + ": cannot be put in place: " + ec.message());
    committed_ = true;
  }

 private:
  std::runtime_error failure(const std::string& what) const {
    return std::runtime_error(target_.string() + ": " + what +
                              (errno != 0 ? std::string(": ") + std::strerror(errno) : ""));
  }
  fs::path target_;
  fs::path part_;
  std::ofstream out_;
  bool committed_ = false;
};

}  // namespace

PrepareOptions held(const PrepareOptions& options, const orient::Candidate& candidate) {
  PrepareOptions out = options;
  auto& brim = out.print.slice.brim_width_mm;
  if (!candidate.printable) brim = out.holding_brim_mm = std::max(brim, kHoldingBrim_mm);
  return out;
}

CutPart cut_part(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                 const run::Context& ctx) {
  Placed placed = place(mesh, pose, options);
  CutPart out;
  out.stack = slice::slice_mesh(placed.mesh, layer_spans(placed.mesh, placed.print.slice, ctx), {}, ctx);
  toolpath::place_on_bed(out.stack, placed.print.machine);
  out.mesh = std::move(placed.mesh);
  out.print = std::move(placed.print);
  return out;
}

PlacedPart placed_part(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options) {
  Placed placed = place(mesh, pose, options);
  PlacedPart part;
  part.mesh = std::move(placed.mesh);
  part.print = std::move(placed.print);
  const auto& machine = part.print.machine;
  if (!machine.origin_at_centre) part.centre_mm = {machine.bed_mm[0] / 2, machine.bed_mm[1] / 2};
  part.holding_brim_mm = options.holding_brim_mm;
  return part;
}

toolpath::EmitStats slice_part(const mesh::TriangleMesh& mesh, const Pose& pose,
                               const PrepareOptions& options, std::ostream& out, const run::Context& ctx,
                               bool pictures) {
  const CutPart part = cut_part(mesh, pose, options, ctx);
  std::future<std::string> drawn;
  if (pictures) drawn = thumbnails(part, ctx);
  const toolpath::Plan plan = toolpath::build(part.stack, part.print, ctx);
  if (plan.layers.empty())
    throw Refused("nothing is left to print: the part is thinner than a line everywhere");
  std::string header = "generated by voidpath\nup in the model: " + orient::number(pose.direction.x(), 6) +
                       ", " + orient::number(pose.direction.y(), 6) + ", " +
                       orient::number(pose.direction.z(), 6) + turn_text(pose.turn_rad);
  if (pictures) header += drawn.get();
  return toolpath::emit(plan, part.print, header, out, options.limits, ctx);
}

SlicedPart slice_part_to(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                         const fs::path& file, const run::Context& ctx) {
  SlicedPart part;
  AtomicFile out(file);
  if (options.slicer) {
    const PlacedPart placed = placed_part(mesh, pose, options);
    part.messages = options.slicer(placed, out.path(), ctx);
    out.sync();
    part.estimate = gcode::estimate_file(out.path(), options.limits, ctx);
    check_foreign(out.path(), placed, part.estimate);
    part.stats = foreign_stats(part.estimate, options.print);
    out.commit();
    return part;
  }
  const auto timed = timed_stream(out.stream(), options.limits, ctx);
  std::ostream& to = timed ? timed->stream() : out.stream();
  if (options.print.machine.progress) {
    std::stringstream text;
    part.stats = slice_part(mesh, pose, options, text, ctx, true);
    gcode::add_progress(text, to, options.limits, ctx);
  } else {
    part.stats = slice_part(mesh, pose, options, to, ctx, true);
  }
  if (timed) {
    timed->stream().flush();
    out.close();
    out.sync();  // what is left to time goes on meanwhile
    part.estimate = timed->finish();
  } else {
    out.close();
    part.estimate = gcode::estimate_file(out.path(), options.limits, ctx);
  }
  out.append(time_comment(part.estimate.predicted_s));
  out.sync();
  ++part.estimate.lines;
  out.commit();
  return part;
}

double time_part(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                 const run::Context& ctx) {
  std::stringstream text;
  slice_part(mesh, pose, options, text, ctx);
  return gcode::estimate(text, options.limits, ctx).predicted_s;
}

}  // namespace voidpath::pipeline

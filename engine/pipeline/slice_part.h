#pragma once

#include "engine/pipeline/prepare.h"
#include "engine/slice/layer.h"

#include <filesystem>
#include <iosfwd>

namespace voidpath::pipeline {

/// How a part stands: `direction` (model space) up by mesh::turned(), then turned about the build axis.
struct Pose {
  Pose(const geom::Vec3& up, double turn = 0) : direction(up), turn_rad(turn) {}
  Pose(const orient::Candidate& c) : direction(c.direction), turn_rad(c.turn_rad) {}
  geom::Vec3 direction;
  double turn_rad = 0;
};

/// A part cut into layers at its place on the bed, and the settings for it: without a skirt that has no room.
struct CutPart {
  mesh::TriangleMesh mesh;  ///< standing on z = 0
  slice::LayerStack stack;
  toolpath::PrintSettings print;
};

/// Standing in that pose; without a turn, turned so that it fits. Throws Refused when it does not fit;
/// run::Stopped.
CutPart cut_part(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                 const run::Context& ctx);

struct SlicedPart {
  toolpath::EmitStats stats;
  gcode::Estimate estimate;
  std::vector<std::string> messages;  ///< of a foreign slicer
};

/// The options with a brim for a candidate that does not stand by itself.
PrepareOptions held(const PrepareOptions& options, const orient::Candidate& candidate);

/// Turned and placed as slice_part() does it. Throws Refused.
PlacedPart placed_part(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options);

/// The part in that pose sliced into `out`.
/// The skirt is left off where only the part itself fits. Throws Refused for anything larger and for a part
/// with nothing to print; run::Stopped. `pictures`: the thumbnails that the machine wants, in the head.
toolpath::EmitStats slice_part(const mesh::TriangleMesh& mesh, const Pose& pose,
                               const PrepareOptions& options, std::ostream& out, const run::Context& ctx,
                               bool pictures = false);

/// The same into a file, by the foreign slicer where the options name one; written beside the file, renamed
/// into place once it is safe on disk, and timed. Throws std::runtime_error naming the file.
SlicedPart slice_part_to(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                         const std::filesystem::path& file, const run::Context& ctx);

/// Only the time it would take, nothing kept.
double time_part(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                 const run::Context& ctx);

}  // namespace voidpath::pipeline

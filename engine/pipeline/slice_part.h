#pragma once

#include "engine/pipeline/prepare.h"

#include <filesystem>
#include <iosfwd>

namespace voidpath::pipeline {

struct SlicedPart {
  toolpath::EmitStats stats;
  gcode::Estimate estimate;
};

/// The options with a brim for a candidate that does not stand by itself.
PrepareOptions held(const PrepareOptions& options, const orient::Candidate& candidate);

/// The part standing in `direction`, turned about the build axis so that it fits, sliced into `out`.
/// The skirt is left off where only the part itself fits. Throws Refused for anything larger and for a part
/// with nothing to print; run::Stopped. `pictures`: the thumbnails that the machine wants, in the head.
toolpath::EmitStats slice_part(const mesh::TriangleMesh& mesh, const geom::Vec3& direction,
                               const PrepareOptions& options, std::ostream& out, const run::Context& ctx,
                               bool pictures = false);

/// The same into a file, written beside it and renamed into place once it is safe on disk, and timed.
/// Throws std::runtime_error naming the file.
SlicedPart slice_part_to(const mesh::TriangleMesh& mesh, const geom::Vec3& direction,
                         const PrepareOptions& options, const std::filesystem::path& file,
                         const run::Context& ctx);

/// Only the time it would take, nothing kept.
double time_part(const mesh::TriangleMesh& mesh, const geom::Vec3& direction, const PrepareOptions& options,
                 const run::Context& ctx);

}  // namespace voidpath::pipeline

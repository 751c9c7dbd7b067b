#pragma once

#include "engine/pipeline/slice_part.h"

#include <cstddef>

/// The time of a print from a sample of its layers.
namespace voidpath::pipeline {

struct SampledTime {
  double seconds = 0;
  std::size_t layers = 0;   ///< of the part
  std::size_t planned = 0;  ///< of these, planned and timed; all: then `seconds` is what time_part() says
};

/// Layers planned for a sample: more change the result by less than what supports found in thick layers do.
inline constexpr std::size_t kSamples = 40;
/// Enough to tell candidates apart that differ much, in a third of the time.
inline constexpr std::size_t kFewSamples = 12;

/// Cuts the whole part, plans the layers that choose_samples() picks and times those with the planner, each
/// standing for its group in proportion to the layers' rough times; `most` layers at most. Throws as
/// time_part() does.
SampledTime sample_time(const mesh::TriangleMesh& mesh, const Pose& pose, const PrepareOptions& options,
                        const run::Context& ctx, std::size_t most = kSamples);

}  // namespace voidpath::pipeline

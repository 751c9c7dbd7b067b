#pragma once

#include "engine/pipeline/prepare.h"

#include <cstddef>
#include <vector>

/// Candidates around a good one, appended to those of the search.
namespace voidpath::pipeline {

/// The same direction turned about the build axis: infill lines get longer or shorter, axes share the way
/// differently. Returns the new ones' indices.
std::vector<std::size_t> add_turns(orient::Choice& choice, std::size_t of, const PrepareOptions& options);

/// Directions some degrees around it, with their criteria; only those that can be printed are added. Scores
/// are taken over all candidates again. Throws run::Stopped.
std::vector<std::size_t> add_neighbours(const mesh::TriangleMesh& mesh, orient::Choice& choice,
                                        std::size_t of, const PrepareOptions& options,
                                        const run::Context& ctx);

}  // namespace voidpath::pipeline

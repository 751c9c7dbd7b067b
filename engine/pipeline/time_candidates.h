#pragma once

#include "engine/pipeline/prepare.h"

namespace voidpath::pipeline {

/// The baselines a choice must never lose to, by name: as delivered, the six axes, the largest resting
/// faces, and what the four- and the three-criteria method would pick. Only printable candidates.
std::map<std::string, std::size_t> find_baselines(const orient::Choice& choice);

/// Slices and times the baselines, then the best and most different candidates until `options.budget_s` is
/// spent, and makes the quickest the chosen one: none of the baselines is quicker. Baselines are timed
/// whatever the budget. With equal times the better score wins.
/// Without options.now_s nothing but the baselines is timed. Throws run::Stopped.
void time_candidates(const mesh::TriangleMesh& mesh, const PrepareOptions& options, orient::Choice& choice,
                     const run::Context& ctx);

}  // namespace voidpath::pipeline

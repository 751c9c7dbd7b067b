#pragma once

#include "engine/pipeline/prepare.h"

namespace voidpath::pipeline {

/// The baselines a choice must never lose to, by name: as delivered, the six axes, the largest resting
/// faces, the lowest, and what the four- and the three-criteria method would pick. Only printable candidates.
std::map<std::string, std::size_t> find_baselines(const orient::Choice& choice);

/// Slices and times the baselines (with them the one of least overhang), then the candidates that promise
/// most until `options.budget_s` is spent or `options.max_extra` are timed, and makes the quickest the chosen
/// one: none of the baselines is quicker. Baselines are timed whatever the budget; candidates that are timed
/// already (predicted_s) keep their time. With equal times the better score wins. Throws run::Stopped.
void time_candidates(const mesh::TriangleMesh& mesh, const PrepareOptions& options, orient::Choice& choice,
                     const run::Context& ctx);

}  // namespace voidpath::pipeline

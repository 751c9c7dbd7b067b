#pragma once

#include "engine/pipeline/prepare.h"

namespace voidpath::pipeline {

/// The baselines a choice must never lose to, by name: as delivered, the six axes, the largest resting
/// faces, the lowest, and what the four- and the three-criteria method would pick. Only printable candidates.
std::map<std::string, std::size_t> find_baselines(const orient::Choice& choice);

/// Makes the quickest candidate the chosen one. In this order, as far as `options.budget_s` reaches:
///  1. the baselines (with them the one of least overhang) are timed on a sample of their layers, of fewer
///     layers where else not all of them would be (`hurry`: known to be so);
///  2. those that may be the quickest, as far as samples can be trusted, are timed in full;
///  3. the candidates that promise most, `options.max_extra` of them at most, likewise;
///  4. what lies around the quickest, likewise: directions some degrees off, and turns about the build axis;
///  5. the remaining baselines are timed in full after all.
/// What is under way when the budget ends is given up. Whatever is left out for want of time is told in
/// choice.timing and choice.why. Where the budget is not spent, the same input gives the same answer on every
/// machine: the clock only says how far down this list to go. A baseline is never quicker than the chosen one, but for an error of its sample larger than any
/// seen. Candidates that are timed already keep their time. With equal times the better score wins. Throws
/// run::Stopped.
void time_candidates(const mesh::TriangleMesh& mesh, const PrepareOptions& options, orient::Choice& choice,
                     const run::Context& ctx, bool hurry = false);

}  // namespace voidpath::pipeline

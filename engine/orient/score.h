#pragma once

#include "engine/orient/search.h"

#include <vector>

namespace voidpath::orient {

/// Fills Candidate::score (eq. 3.1, 3.2): each criterion scaled over all candidates to [0, 1], weighted,
/// added. A criterion all share counts 0. What differs by rounding alone is shared.
void score(std::vector<Candidate>& candidates, const Weights& weights);

}  // namespace voidpath::orient

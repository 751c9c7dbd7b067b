#pragma once

#include "engine/pipeline/budget.h"

namespace voidpath::pipeline {

struct SearchInTime {
  orient::Choice choice;
  bool coarser = false;  ///< fewer directions than the options ask for
};

/// orient::search(), which leaves the better part of the budget for slicing: when its pace shows that it
/// would not, it is broken off. Then the axes and the largest resting faces are looked at, whatever the clock
/// says, and of the other directions as many as there is time for, spread over all sides. Where none of those
/// can be printed, and without a clock or with a budget of 0, where the score alone decides, the search runs
/// to its end. Throws as orient::search() does.
SearchInTime search_in_time(const mesh::TriangleMesh& mesh, const PrepareOptions& options,
                            const Budget& budget, const run::Context& ctx);

}  // namespace voidpath::pipeline

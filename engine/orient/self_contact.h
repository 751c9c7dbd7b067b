#pragma once

#include "engine/orient/solid.h"
#include "engine/run/context.h"

#include <utility>
#include <vector>

namespace voidpath::orient {

/// Nearer than this counts as touching, not crossing: the noise of single-precision coordinates. mm
inline constexpr double kTouch = 1e-5;

/// Pairs of facets that run through one another or lie on one another, as indices in ascending order. Facets
/// that share a corner or an edge, or just touch, do not count.
/// Möller, "A fast triangle-triangle intersection test", 1997, with a tolerance, over a tree of boxes.
std::vector<std::pair<Index, Index>> find_self_contacts(const Solid& solid, const run::Context& ctx);

}  // namespace voidpath::orient

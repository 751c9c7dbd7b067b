#pragma once

#include "engine/orient/solid.h"
#include "engine/run/context.h"

#include <utility>
#include <vector>

namespace voidpath::orient {

/// Nearer than this share of the part's size counts as touching, not crossing: the noise of single-precision
/// coordinates.
inline constexpr double kTouchShare = 1e-7;
inline double touch_mm(const Solid& solid) { return 2 * kTouchShare * solid.radius_mm; }

/// Pairs of facets that run through one another or lie on one another, as indices in ascending order. Facets
/// that share a corner or an edge and nothing else, or just touch, do not count.
/// Möller, "A fast triangle-triangle intersection test", 1997, with a tolerance, over a tree of boxes.
std::vector<std::pair<Index, Index>> find_self_contacts(const Solid& solid, const run::Context& ctx);

}  // namespace voidpath::orient

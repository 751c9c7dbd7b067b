#pragma once

#include "engine/geom/polygon_ops.h"

#include <optional>

namespace voidpath::geom {

enum class Overlay { unite, subtract, intersect };

/// The regions that rings fill: counts how often each side of each edge is gone around. Points that are in no
/// crossing stay as they are; crossings are rounded to whole nm. Nothing where rounding leaves it undecided
/// (never yet seen on outlines of parts): then a sweep must tell.
/// O(n log n + crossings) for evenly spread edges.
std::optional<Regions> filled(const Rings& rings, FillRule rule);

/// The same of two sets, each filled where it is gone around more than 0 times.
std::optional<Regions> overlay(const Rings& a, const Rings& b, Overlay kind);

}  // namespace voidpath::geom

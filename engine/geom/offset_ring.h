#pragma once

#include "engine/geom/polygon_ops.h"

namespace voidpath::geom {

struct OffsetStyle {
  Join join = Join::miter;
  double miter_limit = 2.0;
  double arc_tolerance_nm = 0;
};

/// The ring moved by delta nm to its right (outwards where it runs counter-clockwise), however much it then
/// crosses itself: with those of all rings of a set of regions, it goes more than 0 times around just the
/// places of the true offset. Corners that open are joined in the given style, corners that close become the
/// crossing of their two moved edges where those are long enough. Empty where fewer than three different
/// points follow one another.
Ring raw_offset_ring(const Ring& ring, Coord delta, const OffsetStyle& style);

}  // namespace voidpath::geom

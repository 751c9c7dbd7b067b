#pragma once

#include "engine/geom/polygon.h"

/// Boolean operations and offsets on filled areas, on integer nanometres. Results are regions with
/// outer rings counter-clockwise and holes clockwise, in an order that depends on the input alone.
/// Coordinates should lie within ±1.07 m: beyond, and where rounding leaves an overlay undecided,
/// libpolyclipping (Vatti 1992) does the work.
/// Regions given must be well-formed: disjoint, with rings that run as said above.
/// No function here throws on such input; all may be called from any thread.
/// Outlines of many short edges are slow to offset by more than those edges' length: simplify them first.
namespace voidpath::geom {

enum class FillRule {
  non_zero,  ///< winding number != 0
  even_odd,
  positive  ///< winding number > 0
};

enum class Join { miter, round, square };

/// Any set of closed rings, self-intersecting and overlapping ones included, made into regions.
Regions unite(const Rings& rings, FillRule rule = FillRule::non_zero);
Regions unite(const Regions& a, const Regions& b);
Regions subtract(const Regions& from, const Regions& what);
Regions intersect(const Regions& a, const Regions& b);

/// Grows (delta > 0) or shrinks (delta < 0) by |delta| nm. A miter longer than `miter_limit` × |delta|
/// (2 at least) is squared off at |delta|; round joins keep to 5 µm of the arc.
Regions offset(const Regions& regions, Coord delta, Join join = Join::miter, double miter_limit = 2.0);
/// Shrink then grow: what is thinner than 2·radius goes.
Regions open(const Regions& regions, Coord radius, Join join = Join::miter);
/// Grow then shrink: gaps narrower than 2·radius close.
Regions close(const Regions& regions, Coord radius, Join join = Join::miter);

/// The parts of open lines that lie inside (or outside) the regions. Pieces keep the direction of their
/// line; they are returned in the order of the lines. A stretch along a border is inside or outside as a
/// whole; inside and outside add up to the line.
Polylines clip_inside(const Polylines& lines, const Regions& regions);
Polylines clip_outside(const Polylines& lines, const Regions& regions);

/// Drops points that change the outline by less than `tolerance` nm (Douglas-Peucker), and rings that
/// collapse.
Regions simplify(const Regions& regions, Coord tolerance);
Polyline simplify(const Polyline& line, Coord tolerance);

/// Drops regions and holes smaller than `min_area_nm2`.
Regions remove_small(const Regions& regions, double min_area_nm2);

/// Narrow copy for one-off drawing and for tests.
Ring make_rectangle(Point min, Point max);
/// Regular polygon with `sides` vertices on the circle, counter-clockwise.
Ring make_circle(Point centre, Coord radius, int sides = 64);

}  // namespace voidpath::geom

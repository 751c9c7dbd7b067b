#pragma once

#include "engine/geom/polygon.h"
#include "engine/geom/polygon_ops.h"

/// Boolean operations that answer the frequent easy cases (equal, empty, apart) without the polygon
/// library.
namespace voidpath::toolpath {

bool overlap(const geom::Box& a, const geom::Box& b);
geom::Box grown(const geom::Box& box, geom::Coord by);

geom::Regions quick_intersect(const geom::Regions& a, const geom::Regions& b);
geom::Regions quick_subtract(const geom::Regions& from, const geom::Regions& what);
geom::Regions quick_unite(const geom::Regions& a, const geom::Regions& b);
/// The regions whose bounding boxes touch `box`.
geom::Regions near_box(const geom::Regions& regions, const geom::Box& box);
void append(geom::Regions& to, geom::Regions&& more);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/geom/polygon.h"

#include <vector>

namespace voidpath::toolpath {

/// A line down the middle of a thin area, with the area's width at each of its points.
struct CentreLine {
  geom::Polyline points;
  std::vector<double> width_mm;
  bool closed = false;
};

/// The middle lines of a thin area by the chordal axis transform (Prasad 1997): the area is triangulated
/// (constrained Delaunay), and the middles of the inner edges are joined from triangle to triangle. Branches
/// shorter than the area is wide there are left out.
std::vector<CentreLine> centre_lines(const geom::Region& area);

}  // namespace voidpath::toolpath

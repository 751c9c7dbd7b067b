#pragma once

#include "engine/geom/polygon.h"

#include <vector>

namespace voidpath::toolpath {

/// One straight or curved piece of a way, from where the last one ended.
struct Stroke {
  geom::Point to;
  std::size_t last = 0;  ///< the line's vertex there
  int turn = 0;          ///< 0 straight, +1 counter-clockwise arc, -1 clockwise arc
  geom::Point centre;    ///< of an arc
};

/// The line as arcs where at least three of its pieces lie on one, and as it is elsewhere. No point of the
/// line is further than `tolerance_mm` from the result, nor the other way round. Every stroke ends in a
/// vertex of the line.
std::vector<Stroke> fit_arcs(const geom::Polyline& line, double tolerance_mm);

}  // namespace voidpath::toolpath

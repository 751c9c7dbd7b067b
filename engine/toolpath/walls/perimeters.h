#pragma once

#include "engine/geom/polygon.h"
#include "engine/toolpath/settings.h"

#include <cstddef>
#include <vector>

namespace voidpath::toolpath {

/// Widths of the beads in one layer, mm.
struct BeadSize {
  double width_mm = 0.45;
  double height_mm = 0.2;
  double spacing_mm() const;
  double area_mm2() const;
};

/// The bead of a layer, from the settings: the first layer has widths of its own.
BeadSize bead_of_layer(const SliceSettings& settings, std::size_t layer, double height_mm);

/// A wall's centre line.
struct Loop {
  geom::Ring ring;  ///< counter-clockwise around material, clockwise around a hole
  int depth = 0;    ///< 0: external
  bool is_hole = false;
};

/// Loops that lie in one another along the same wall; printed together, in order of depth.
using Wall = std::vector<Loop>;

struct Perimeters {
  std::vector<Wall> walls;     ///< each from the external loop inwards
  geom::Regions inner;         ///< what remains inside the beads, for infill
  geom::Regions gaps;          ///< slivers that no bead of full width fits in
  std::size_t at_outline = 0;  ///< so many of the gaps, the first ones, are not inside a wall
  geom::Regions thin;          ///< the whole outline where not even one loop fits in
};

/// Walls of one region.
Perimeters make_perimeters(const geom::Region& outline, int count, const BeadSize& bead);

/// Moves what of an area is narrower than this to `strips`, which are to be lines of their own, but for
/// threads too thin to print.
void take_strips(geom::Regions& strips, geom::Regions& area, double least_mm, const BeadSize& bead);

}  // namespace voidpath::toolpath

#pragma once

#include "engine/run/context.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"

#include <vector>

namespace voidpath::toolpath {

/// Directions of one layer's lines, radians counter-clockwise from x.
struct FillDirections {
  double solid = 0;
  double sparse = 0;
  double thick = 0;        ///< of infill printed for several layers
  double over_sparse = 0;  ///< across the sparse lines of the layer below
};

/// Seconds that lines in this direction take over the area, each from rest to rest, at the speed and
/// acceleration given (mm/s, mm/s²), their ends' links left out. Judged by fewer lines than are printed.
double seconds_of_lines(const geom::Regions& area, double angle_rad, double spacing_mm, double speed_mm_s,
                        double acceleration_mm_s2);

/// Directions of all layers. Fixed: as the settings say, turned by 90° from layer to layer. Part: the same
/// with the angle that takes least time over all layers. Layer: each solid layer's own best direction, at
/// 45° or more to that of the layer below, chosen for the sum of all (Viterbi); sparse lines as for the part,
/// since they have to meet from layer to layer.
std::vector<FillDirections> choose_directions(const std::vector<Surfaces>& surfaces,
                                              const PrintSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

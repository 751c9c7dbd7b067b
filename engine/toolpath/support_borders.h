#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/supports.h"

#include <vector>

namespace voidpath::toolpath {

/// From one line of support to the next at this density, mm: the same in every layer, so that lines lie on
/// lines.
double support_line_distance_mm(const SliceSettings& settings, double density);

/// Where sparse lines lie, in y: of each part of the plate that has columns, on a lattice of its own, put so
/// that the columns' borders are least far from a line.
struct SupportLattice {
  struct Field {
    geom::Region area;
    geom::Coord shift = 0;  ///< of a lattice through the plate's origin
  };
  std::vector<Field> fields;

  geom::Coord shift_at(const geom::Point& p) const;
};

/// Where columns are so narrow that sparse lines may miss them, their border is printed, and where they go on
/// beyond the last line: sets `bordered` and `caps`.
/// Where that begins above wider column, a border would hang between the lines below: there that layer gets
/// dense lines across, `floor`. Sets `lattice` as well. `columns`: all of each layer's column, dense parts
/// included; they stand below `contact`.
void border_narrow_columns(std::vector<SupportAreas>& areas, const std::vector<geom::Regions>& columns,
                           const std::vector<geom::Regions>& contact, const SliceSettings& settings,
                           const run::Context& ctx);

}  // namespace voidpath::toolpath

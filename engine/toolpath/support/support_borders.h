#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/supports.h"

#include <memory>
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

/// For columns of each layer below these contacts; where sparse lines lie so near to one another that they
/// miss nothing, or there are none: null.
std::shared_ptr<const SupportLattice> choose_lattice(const std::vector<geom::Regions>& columns,
                                                     const std::vector<geom::Regions>& contact,
                                                     const SliceSettings& settings, const run::Context& ctx);

/// What of a layer's column gets lines along its border.
struct ColumnBorders {
  geom::Regions narrow;  ///< so narrow that sparse lines may miss it: all around
  geom::Polylines caps;  ///< where the column goes on beyond the last line
  geom::Regions all;     ///< the area of all those borders
};

/// `column`: all of it, dense parts included.
ColumnBorders find_borders(const geom::Regions& column, const SupportLattice& lattice, double line_width_mm,
                           const SliceSettings& settings);

/// Sets `bordered`, `caps` and `lattice` of the areas. Where a border begins above wider column, it would
/// hang between the lines below: there that layer gets dense lines across, `floor`.
void border_columns(std::vector<SupportAreas>& areas, const std::vector<geom::Regions>& columns,
                    const std::vector<ColumnBorders>& borders,
                    const std::shared_ptr<const SupportLattice>& lattice, const SliceSettings& settings,
                    const run::Context& ctx);

}  // namespace voidpath::toolpath

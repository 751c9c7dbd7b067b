#pragma once

#include "engine/geom/polygon.h"
#include "engine/slice/layer.h"

#include <optional>
#include <string_view>
#include <vector>

namespace voidpath::toolpath {

/// What a stretch of extrusion is for. Names in G-code follow PrusaSlicer's `;TYPE:` vocabulary.
enum class Role {
  skirt_brim,
  external_perimeter,
  perimeter,
  overhang_perimeter,
  infill,
  solid_infill,
  top_solid_infill,
  bridge_infill,
  internal_bridge,  ///< solid lines that span the gaps of sparse infill
  gap_fill,
  support,
  support_interface,
};

/// "External perimeter", "Internal infill", ...
std::string_view type_name(Role role);

/// A path that climbs: z and the share of the bead's cross-section change evenly along its length.
struct Rise {
  double from_mm = 0;  ///< nozzle height at the path's first point
  double to_mm = 0;
  double share_from = 1;
  double share_to = 1;
};

/// One continuous extrusion at constant width and height. Points in plate coordinates, nm. A closed path
/// ends where it began (the first point is not repeated).
struct Path {
  Role role = Role::infill;
  geom::Polyline points;
  bool closed = false;
  double width_mm = 0.45;
  double height_mm = 0.2;  ///< thickness of the bead; a bridge's is its diameter
  /// Bead cross-section, mm²: volume per length before the filament's flow factor.
  double area_mm2 = 0;
  double max_speed_mm_s = 0;  ///< beside the role's; 0: no limit of its own
  std::optional<Rise> rise;  ///< absent: level, at the layer's top, with the whole cross-section
};

/// Everything printed at one height, in printing order. Travels between paths are added by emit().
struct LayerPlan {
  slice::LayerSpan span;
  std::vector<Path> paths;
  /// The part's own outline in this layer, for travel that should stay inside.
  geom::Regions outline;
  /// Where support is printed.
  geom::Regions support;
};

struct Plan {
  std::vector<LayerPlan> layers;
};

}  // namespace voidpath::toolpath

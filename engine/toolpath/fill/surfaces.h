#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/walls/perimeters.h"

#include <vector>

namespace voidpath::toolpath {

/// An area that is bridged, and how.
struct BridgeArea {
  geom::Regions area;    ///< with its anchors, within the walls
  geom::Region hanging;  ///< the part over air
  geom::Regions ground;  ///< what carries its lines, in and near the area; under the walls as well
  double angle_rad = 0;
  double span_mm = 0;     ///< of its longest line
  bool anchored = false;  ///< held at both ends; otherwise it needs support
};

/// The inside of one layer's walls, by what fills it. Areas don't overlap.
struct Surfaces {
  std::vector<BridgeArea> bridges;
  std::vector<BridgeArea> internal_bridges;  ///< over sparse infill
  geom::Regions unheld;                      ///< of solid and top, what hangs without hold and wants support
  geom::Regions top;
  geom::Regions solid;
  geom::Regions sparse;
  geom::Regions thick;    ///< sparse infill of several layers, printed in the last of them
  double thick_mm = 0;    ///< their height
  std::size_t group = 0;  ///< of layers whose infill is printed together
};

/// Solid areas reach this many line widths into the sparse area beside them, to hold on to.
inline constexpr double kSkinAnchorWidths = 1.0;

/// Sorts every layer's `inner` area: solid where any of the next top_layers layers above or bottom_layers
/// below is missing, or of as many more as the least thicknesses ask for, with an overlap into the sparse
/// area; then find_internal_bridges(). A layer whose `inner` is empty costs nothing.
std::vector<Surfaces> find_surfaces(const slice::LayerStack& stack, const std::vector<geom::Regions>& inner,
                                    const SliceSettings& settings, const run::Context& ctx);

/// What of the layer below carries the lines of a bridge: as far as a strand's middle may leave it.
geom::Regions bridge_ground(const geom::Regions& below, const geom::Regions& area, double line_width_mm);

/// The best direction to bridge `hanging` over the layer below, and whether its lines find hold at both
/// ends. `reach_mm`: how far beyond the area its lines go on (walls and anchor).
BridgeArea plan_bridge(const geom::Region& hanging, const geom::Regions& below, double reach_mm);

}  // namespace voidpath::toolpath

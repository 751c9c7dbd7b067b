#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/tree_room.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace voidpath::toolpath {

/// A branch's section in one layer.
struct BranchSection {
  geom::Point centre;
  double radius_mm = 0;
  std::optional<std::size_t> below;  ///< in the layer below: what it stands on
};

struct Branches {
  std::vector<std::vector<BranchSection>> sections;  ///< by layer
  std::vector<geom::Regions> unheld;                 ///< of what was to be held, by layer: out of reach
};

/// Branches whose tips are in layer i below held[i], from the top down.
Branches grow_branches(const std::vector<geom::Regions>& held, const slice::LayerStack& stack,
                       const TreeRoom& room, const SliceSettings& settings, const run::Context& ctx);

/// Places for tips that hold the area, near its border and inside, at most about `apart` nm from one another.
std::vector<geom::Point> tip_places(const geom::Regions& area, double tip_radius, double apart);

}  // namespace voidpath::toolpath

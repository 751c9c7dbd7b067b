#pragma once

#include "engine/geom/polygon.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/fill_directions.h"
#include "engine/toolpath/fill/infill.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/plan.h"
#include "engine/toolpath/settings.h"
#include "engine/toolpath/support/supports.h"
#include "engine/toolpath/walls/perimeters.h"

#include <vector>

/// What a layer prints, before order, seams and overhangs are decided. Layers don't depend on each other
/// here, so they are drafted in parallel.
namespace voidpath::toolpath {

/// One connected area of the part: printed in one go before the nozzle moves on.
struct IslandDraft {
  std::vector<Wall> walls;
  std::vector<Path> fills;  ///< may be printed from either end, in any order
};

struct LayerDraft {
  std::vector<Path> around;   ///< skirt and brim, in order
  std::vector<Path> support;  ///< in any order, from either end
  std::vector<IslandDraft> islands;
};

/// The walls of one layer's islands.
struct LayerWalls {
  BeadSize bead;
  std::vector<Perimeters> islands;  ///< one for each region of the layer
};

LayerWalls draft_walls(const slice::Layer& layer, std::size_t index, const SliceSettings& settings);

/// All inner areas of the layer together.
geom::Regions inner_of(const LayerWalls& walls);

/// Lines for every area of the layer, handed to the islands they belong to, which take the walls over; what
/// fill alone leaves bare where there are none is added to the gaps, the rest of `walls` stays as it is.
/// `lightning`: its sparse infill where that is the pattern.
LayerDraft draft_layer(const slice::Layer& layer, std::size_t index, LayerWalls& walls,
                       const Surfaces& surfaces, const FillDirections& directions,
                       const geom::Polylines& lightning, const SupportAreas& support,
                       const PrintSettings& settings);

}  // namespace voidpath::toolpath

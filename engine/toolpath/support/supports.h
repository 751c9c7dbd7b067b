#pragma once

#include "engine/geom/polygon.h"
#include "engine/run/context.h"
#include "engine/slice/layer.h"
#include "engine/toolpath/fill/surfaces.h"
#include "engine/toolpath/settings.h"

#include <memory>
#include <vector>

namespace voidpath::toolpath {

/// Density of support right under the part.
inline constexpr double kInterfaceDensity = 0.8;

struct SupportLattice;

/// Where support is printed in one layer.
struct SupportAreas {
  geom::Regions sparse;
  geom::Regions interface;  ///< dense, right below what is held
  geom::Regions branches;   ///< of trees: hollow, with a wall of their own
  geom::Regions floor;      ///< dense, below borders that begin
  geom::Regions bordered;   ///< of line centres in what is sparse: too narrow for its lines
  std::shared_ptr<const SupportLattice> lattice;  ///< of what is sparse; one for all layers
  geom::Polylines caps;  ///< along the border of what is sparse, beyond the last of its lines
};

/// All of it together.
geom::Regions printed_area(const SupportAreas& areas);

/// Columns below every overhang that leans out more than the settings' angle and is not bridged, one per
/// layer of the stack. They keep the xy gap beside the part and the z gap above and below it.
std::vector<SupportAreas> find_supports(const slice::LayerStack& stack, const std::vector<Surfaces>& surfaces,
                                        const SliceSettings& settings, const run::Context& ctx);

}  // namespace voidpath::toolpath

#include "engine/toolpath/plan.h"

namespace voidpath::toolpath {

std::string_view type_name(Role role) {
  switch (role) {
    case Role::skirt_brim:
      return "Skirt/Brim";
    case Role::external_perimeter:
      return "External perimeter";
    case Role::perimeter:
      return "Perimeter";
    case Role::overhang_perimeter:
      return "Overhang perimeter";
    case Role::infill:
      return "Internal infill";
    case Role::solid_infill:
      return "Solid infill";
    case Role::top_solid_infill:
      return "Top solid infill";
    case Role::internal_bridge:
      return "Internal bridge infill";  // SuperSlicer's word; PrusaSlicer has none
    case Role::bridge_infill:
      return "Bridge infill";
    case Role::gap_fill:
      return "Gap fill";
    case Role::support:
      return "Support material";
    case Role::support_interface:
      return "Support material interface";
  }
  return "Custom";
}

}  // namespace voidpath::toolpath

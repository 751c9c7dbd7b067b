#include "tests/fidelity/modes.h"

#include <algorithm>
#include <stdexcept>

namespace voidpath::fidelity {

bool Mode::suits(const std::string& shape) const {
  return std::find(shapes.begin(), shapes.end(), shape) != shapes.end();
}

Bounds Mode::bounds(const Rules& rules) const {
  Bounds b = bounds_for(rules);
  // One round wall follows the outline wherever it leans: what is too much is for whoever chooses a vase.
  if (rules.vase) b.held = false;
  const auto is_set = [&](const char* key, const char* value) {
    return std::find(set.begin(), set.end(), std::pair<std::string, std::string>{key, value}) != set.end();
  };
  // Without a roof the part's underside is a web of bridges from tip to tip, whose pieces meet anywhere: a
  // line may be missing between two of them.
  if (is_set("slice.support_interface_layers", "0")) b.bottom_hole = rules.line_width;
  return b;
}

const std::vector<Mode>& modes() {
  static const std::vector<Mode> all = {
      {"trees", {{"slice.support_style", "tree"}}, {"spool", "ball"}},
      {"trees from the plate", {{"slice.support_style", "tree"}, {"slice.support", "plate"}}, {"ball"}},
      {"columns from the plate", {{"slice.support", "plate"}}, {"spool"}},
      {"trees without roofs",
       {{"slice.support_style", "tree"}, {"slice.support_interface_layers", "0"}},
       {"spool"}},
      {"dense support",
       {{"slice.support_density", "0.3"},
        {"slice.support_z_gap_mm", "0.1"},
        {"slice.support_angle_deg", "55"},
        {"slice.support_xy_gap_mm", "0.8"}},
       {"spool", "ball"}},
      {"raft", {{"slice.raft_layers", "4"}}, {"spool"}},
      {"raft under trees", {{"slice.raft_layers", "2"}, {"slice.support_style", "tree"}}, {"ball"}},
      {"vase", {{"slice.spiral_vase", "true"}}, {"beaker", "finned"}},
      {"adaptive layers", {{"slice.adaptive_layers", "true"}}, {"spool", "ball"}},
      {"concentric skins",
       {{"slice.solid_pattern", "concentric"}, {"slice.top_pattern", "concentric"}},
       {"drilled"}},
      {"concentric, solid",
       {{"slice.solid_pattern", "concentric"},
        {"slice.top_pattern", "concentric"},
        {"slice.infill_density", "1"}},
       {"beaker"}},
      {"Fermat skins",
       {{"slice.solid_pattern", "fermat"}, {"slice.top_pattern", "fermat"}},
       {"beaker", "drilled"}},
      {"Fermat, solid",
       {{"slice.solid_pattern", "fermat"}, {"slice.top_pattern", "fermat"}, {"slice.infill_density", "1"}},
       {"drilled"}},
      {"lightning", {{"slice.infill_pattern", "lightning"}}, {"spool", "beaker"}},
      {"external first",
       {{"slice.external_perimeters_first", "true"}, {"slice.perimeters", "3"}},
       {"drilled", "ball"}},
      {"combined infill",
       {{"slice.infill_every_layers", "3"},
        {"slice.layer_height_mm", "0.12"},
        {"slice.infill_density", "0.2"}},
       {"beaker"}},
      {"brim",
       {{"slice.brim_width_mm", "3"}, {"slice.brim_type", "both"}, {"slice.skirt_loops", "0"}},
       {"drilled", "spool"}},
      {"ears",
       {{"slice.brim_width_mm", "4"}, {"slice.brim_type", "ears"}, {"slice.skirt_loops", "0"}},
       {"drilled"}},
      {"larger", {{"slice.xy_compensation_mm", "0.15"}, {"slice.infill_density", "1"}}, {"drilled"}},
      {"smaller, wider holes",
       {{"slice.xy_compensation_mm", "-0.15"},
        {"slice.hole_compensation_mm", "0.2"},
        {"slice.infill_density", "1"}},
       {"drilled"}},
      {"elephant foot", {{"slice.elephant_foot_mm", "0.2"}, {"slice.infill_density", "1"}}, {"drilled"}},
      {"no walls, solid", {{"slice.perimeters", "0"}, {"slice.infill_density", "1"}}, {"drilled"}},
      {"arcs", {{"machine.arcs", "true"}}, {"beaker", "ball"}},
  };
  return all;
}

const Mode& mode(const std::string& name) {
  for (const Mode& m : modes())
    if (m.name == name) return m;
  throw std::logic_error("no mode is called " + name);
}

}  // namespace voidpath::fidelity

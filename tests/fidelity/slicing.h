#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "engine/pipeline/slice_part.h"
#include "engine/run/context.h"
#include "tests/fidelity/check.h"
#include "tests/support/real_models.h"

#include <string>
#include <utility>
#include <vector>

/// Parts sliced to be looked at.
namespace voidpath::fidelity {

/// Keys of a configuration and their values.
using Set = std::vector<std::pair<std::string, std::string>>;

/// Of a plain printer with a bed larger than any part: placement is not what is looked at here.
pipeline::PrepareOptions options_for(const Set& set);

struct Sliced {
  mesh::TriangleMesh placed;
  std::string gcode;
  Rules rules;
  double filament_diameter = 1.75, flow = 1;
};

/// As it stands.
Sliced sliced(const mesh::TriangleMesh& mesh, const pipeline::PrepareOptions& options,
              const run::Context& ctx = {});

/// A real part at the size it is printed in.
mesh::TriangleMesh imported(const test::RealModel& model);

/// The G-code as strands; whatever could not be understood is in the print's complaints.
Print read(const Sliced& part);
Findings checked(const Sliced& part);

/// Beyond its section by the compensation that is allowed, mm, and the pixels' error.
double outside_limit(const Findings& f);
/// Where lines of a skin turn, a corner stays open: half its width, mm, and the pixels' error.
double hole_limit(const Findings& f);
/// The tip of a strand may stick out by its own width, mm.
inline constexpr double kTip = 0.5;

/// Where a way of slicing allows more than all others.
struct Bounds {
  bool held = true;         ///< the part's strands are to have something to lie on
  double bottom_hole = 0;   ///< if more than otherwise, mm
  double support_span = 0;  ///< of a support's strand that is held at both ends, mm
};
Bounds bounds_for(const Rules& rules);

/// A finding beyond what is allowed, or a complaint of reading, which has no figures.
struct Excess {
  std::string name;
  double value = 0, limit = 0;
  std::string where;
};
std::vector<Excess> excesses(const Findings& f, const Bounds& bounds);
/// Their names.
std::vector<std::string> beyond_bounds(const Findings& f, const Bounds& bounds);
/// All of them, to be read.
std::string told(const std::string& name, const Findings& f);

}  // namespace voidpath::fidelity

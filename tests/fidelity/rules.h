#pragma once

#include <cstddef>

namespace voidpath::fidelity {

/// What was asked for beside the mesh. mm.
struct Rules {
  double line_width = 0.45;
  double infill_density = 0.15;  ///< 0 to 1
  double support_density = 0.15;
  double support_angle_deg = 45;  ///< what leans out further must be held
  double support_z_gap = 0.2;
  double support_reach = 0.5;    ///< what is printed may be so far beside support
  double branch_angle_deg = 45;  ///< support may lean out so far
  /// Support stands on the plate alone: what has the part below itself, a gap away at least, or a line's
  /// width beside that, need not be held.
  bool from_plate = false;
  /// Where the part begins: above the raft and its gap; 0 on the plate.
  double ground = 0;
  double outer_growth = 0;  ///< by which outer contours are to be larger than the mesh
  double hole_growth = 0;   ///< by which holes are
  double foot = 0;          ///< by which the first layer is to be smaller, where it is wide
  bool vase = false;        ///< from `floor_layers` on one round each layer that climbs, nothing inside
  std::size_t floor_layers = 0;
  double largest_pixel = 0.05;
  std::size_t most_pixels = 2'000'000;
};

}  // namespace voidpath::fidelity

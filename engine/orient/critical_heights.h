#pragma once

#include "engine/orient/search.h"
#include "engine/orient/solid.h"

#include <vector>

/// Where along a direction the slices of a part change in kind (§3.2.2).
namespace voidpath::orient {

/// Heights nearer than this are one height: the noise of coordinates kept in single precision. mm
inline constexpr double kHeightNoise = 1e-6;

/// One representative slice.
struct Slab {
  double middle_mm;        ///< where it is cut
  double weight_up = 0;    ///< its share of the height for the direction itself; 0: not among its slices
  double weight_down = 0;  ///< the same for the opposite direction
};

/// Slices of direction d and of -d, lowest first, as seen along d. The rule that drops heights works upwards
/// from the plate, so the two directions can keep different ones. `heights` are those of the vertices along
/// d; `lowest` and `highest` bound them.
void find_slabs(const Solid& solid, const Vec3& d, const std::vector<double>& heights, double lowest,
                double highest, const SearchOptions& options, std::vector<Slab>& out);

}  // namespace voidpath::orient

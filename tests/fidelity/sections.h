#pragma once

#include "engine/mesh/triangle_mesh.h"
#include "tests/fidelity/beads.h"
#include "tests/fidelity/mask.h"
#include "tests/fidelity/rules.h"

#include <cstdint>
#include <vector>

namespace voidpath::fidelity {

/// A face may lie in the very height of the cut, and digits decide which side counts: both are right.
struct Section {
  Mask most, least;
};

/// What each layer should be: the mesh cut at the layer's middle, with the compensations the rules name. All
/// are references to what outlives it.
class Sections {
 public:
  Sections(const mesh::TriangleMesh& mesh, const Print& print, const Rules& rules, const Grid& grid);
  /// Of one layer; nothing above the last and below the part.
  Section of(std::size_t layer) const;

 private:
  double cut(const Layer& l) const { return l.top - 0.5 * l.height; }
  bool grazed(const std::vector<std::uint32_t>& triangles, double z) const;
  Mask asked_for(Mask cut, std::size_t layer, bool least) const;

  const mesh::TriangleMesh& mesh_;
  const Print& print_;
  const Rules& rules_;
  const Grid& grid_;
  std::vector<std::vector<std::uint32_t>> by_layer_;  ///< triangles
};

/// Each of the areas grown by `outer` at its outside, mm, and its holes widened by `hole`; either may be
/// negative.
Mask compensated(const Mask& areas, const Grid& grid, double outer, double hole);

/// With what they enclose.
Mask without_holes(const Mask& areas, const Grid& grid);

}  // namespace voidpath::fidelity

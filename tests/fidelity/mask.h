#pragma once

#include "tests/fidelity/beads.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace voidpath::fidelity {

/// Square pixels over a rectangle of the plate. Pixel (i, j) is the square whose middle is
/// (x0 + (i + 0.5) size, y0 + (j + 0.5) size), mm.
struct Grid {
  double x0 = 0, y0 = 0, size = 0.05;
  int nx = 0, ny = 0;

  std::size_t count() const { return static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny); }
  std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx) + static_cast<std::size_t>(i);
  }
  double area() const { return size * size; }
};

using Mask = std::vector<std::uint8_t>;  ///< 1 where something is

/// Marks the pixels whose middle the strand covers, its round ends included.
void draw(Mask& mask, const Grid& grid, const Bead& bead, double wider = 0);

/// A segment of a section; the material lies to the left.
struct Edge {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// Pixels whose middle the edges wind around at least once, counter-clockwise. No rings are needed.
Mask fill(const std::vector<Edge>& edges, const Grid& grid);

/// Distance from each pixel's middle to the nearest marked pixel's middle, mm; 0 on marked ones.
std::vector<float> distance_to(const Mask& mask, const Grid& grid);

Mask grown(const Mask& mask, const Grid& grid, double by);
Mask shrunk(const Mask& mask, const Grid& grid, double by);
Mask both(const Mask& a, const Mask& b);
Mask without(const Mask& a, const Mask& b);
std::size_t count(const Mask& mask);

}  // namespace voidpath::fidelity

#pragma once

#include "tests/fidelity/beads.h"

#include <cstddef>
#include <cstdint>
#include <optional>
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
  /// The pixel that holds the point, if any does.
  std::optional<std::size_t> pixel(double x, double y) const;
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
/// Adds the pixels that edges pass through where nothing is marked right around: what is thinner than a pixel
/// may lie between the middles of two.
void add_slivers(Mask& areas, const std::vector<Edge>& edges, const Grid& grid);

/// Distance from each pixel's middle to the nearest marked pixel's middle, mm; 0 on marked ones.
std::vector<float> distance_to(const Mask& mask, const Grid& grid);

/// A part of a grid, and what is marked in it.
struct Window {
  Grid grid;
  Mask mask;
  int i0 = 0, j0 = 0;  ///< where it begins in the whole

  Mask same(const Mask& whole, const Grid& of) const;  ///< this part of another mask
  /// Index in the whole of one in the window.
  std::size_t whole(std::size_t pixel, const Grid& of) const;
};
/// Around all that is marked and `margin` pixels more; an empty mask where nothing is.
Window cropped(const Mask& mask, const Grid& grid, int margin);
/// The same around some pixels, where nothing else is marked.
Window around(const std::vector<std::size_t>& pixels, const Grid& grid, int margin);
/// Pixels all of whose neighbours up to `by` pixels to the sides and up and down are marked: what a disc of
/// √2 by would leave, and more.
Mask shrunk_square(const Mask& mask, const Grid& grid, int by);
/// Distance to the nearest marked pixel, mm, if one lies within `reach` pixels to the sides and up and down
/// and the nearest is certain to be among them.
std::optional<double> near(const Mask& mask, const Grid& grid, std::size_t pixel, int reach);

/// Answers whether anything marked lies near many pixels. Keeps references to what it is given.
class Nearby {
 public:
  Nearby(const Mask& mask, const Grid& grid);
  bool within(std::size_t pixel, double reach_mm);

 private:
  static constexpr int kTile = 8;  ///< pixels
  std::size_t tile(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(nx_) + static_cast<std::size_t>(i);
  }
  const Mask& mask_;
  const Grid& grid_;
  int nx_, ny_;
  Mask tiles_;              ///< those that hold anything
  std::vector<float> far_;  ///< made when the tiles do not tell
};

Mask grown(const Mask& mask, const Grid& grid, double by);
Mask shrunk(const Mask& mask, const Grid& grid, double by);
Mask both(const Mask& a, const Mask& b);
Mask without(const Mask& a, const Mask& b);
std::size_t count(const Mask& mask);

}  // namespace voidpath::fidelity

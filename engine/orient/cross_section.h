#pragma once

#include "engine/orient/critical_heights.h"
#include "engine/orient/trapped_volume.h"

#include <array>
#include <vector>

namespace voidpath::orient {

struct Point2 {
  double x = 0;
  double y = 0;
};

/// Contours that enclose less are lines or points, not regions: the plane grazes the part there. mm²
inline constexpr double kLeastArea = 1e-9;

/// One closed line of a slice; counter-clockwise around material, seen from above.
struct Contour {
  std::size_t begin = 0;  ///< range in CrossSections::points()
  std::size_t end = 0;
  Index shell = 0;
  double area_mm2 = 0;  ///< signed
  /// Which region it belongs to and whether it lies within that region's outline: only where SliceFill told.
  Index region = kNone;
  bool is_inner = false;
};

/// Slices of a projected part, by walking from facet to facet.
///
/// A vertex at a slice's height counts as above it, and so does one below it by rounding (kHeightNoise):
/// between bodies stacked on one another no slice falls into the crack. So each facet is crossed on two edges
/// or none, every crossed edge leads on to the facet beside it, and the lines close without any matching of
/// points, also where a plane runs through vertices or along faces. A facet is entered by the edge that falls
/// below the plane and left by the one that rises above it: the material then lies to the left. Not
/// thread-safe; keeps its memory from one use to the next.
class CrossSections {
 public:
  /// Fixes the heights; afterwards trace() may be called for each of them, in any order.
  void prepare(const Solid& solid, const Projection& p, const std::vector<Slab>& slabs);

  /// Finds the contours of slice i. Their points are not computed yet.
  void trace(std::size_t i);
  /// Computes the points and areas of the contours.
  void place();

  /// Whether the slice last traced cuts facet t.
  bool cuts(Index t) const { return seen_[t] == mark_; }
  /// The contour of the traced slice that facet t, which the slice cuts, lies on; kept only for solids whose
  /// shells meet.
  Index contour_of(Index t) const { return contour_of_[t]; }
  std::vector<Contour>& contours() { return contours_; }
  std::vector<Point2>& points() { return points_; }

 private:
  struct CrossedEdge {
    Index below, above;
  };
  Index leave(Index t, Index slice);
  void fill_block(std::size_t i);

  const Solid* solid_ = nullptr;
  const Projection* p_ = nullptr;
  const std::vector<Slab>* slabs_ = nullptr;
  std::vector<Index> rank_;   ///< per vertex: number of slices at or below it
  std::vector<Index> start_;  ///< per step of height: number of slices below the step
  struct Crossing {
    Index facet, from, to;  ///< crossed by slices [from, to)
  };
  std::vector<Crossing> crossings_;
  std::vector<std::size_t> count_;  ///< per slice, then prefix sums: where its facets start
  std::vector<Index> facets_;       ///< of the slices in the block, slice by slice
  std::size_t block_begin_ = 0, block_end_ = 0;
  std::vector<Index> seen_;  ///< per facet: 1 + last slice whose trace passed it
  Index mark_ = 0;
  std::vector<Index> contour_of_;
  std::vector<CrossedEdge> edges_;
  std::vector<Contour> contours_;
  std::vector<Point2> points_;
  double height_ = 0;
};

}  // namespace voidpath::orient

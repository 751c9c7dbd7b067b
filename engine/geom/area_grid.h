#pragma once

#include "engine/geom/edge_grid.h"
#include "engine/geom/polygon.h"

#include <cstdint>
#include <vector>

namespace voidpath::geom {

/// A stretch of a line that lies wholly inside or outside.
struct Piece {
  Polyline points;
  bool inside = false;
};

/// Filled areas, for many questions about them. Immutable after construction; may be asked from any thread.
class AreaGrid {
 public:
  struct Crossing {
    double t = 0;            ///< position in (0, 1) along the line
    std::uint32_t edge = 0;  ///< index in edges()
  };

  explicit AreaGrid(const Regions& regions);

  bool empty() const { return edges_.empty(); }
  /// Of rings_of(regions), as edges_of() lists them.
  const std::vector<Edge>& edges() const { return edges_; }
  bool contains(const Point& p) const;
  /// Whether the straight line runs inside from end to end.
  bool contains(const Point& a, const Point& b) const;
  /// Cuts the line where it crosses the border; neighbouring pieces share their end point.
  std::vector<Piece> split(const Polyline& line) const;
  /// Where the straight line crosses the border, ascending.
  void crossings(const Point& a, const Point& b, std::vector<Crossing>& out) const;

 private:
  std::vector<Edge> edges_;
  EdgeGrid grid_;
};

}  // namespace voidpath::geom

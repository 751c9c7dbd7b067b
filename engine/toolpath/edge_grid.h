#pragma once

#include "engine/geom/polygon.h"

#include <cstdint>
#include <vector>

namespace voidpath::toolpath {

/// A stretch of a line that lies wholly inside or outside.
struct Piece {
  geom::Polyline points;
  bool inside = false;
};

/// The borders of filled areas, sorted into the cells of a grid, for many questions about one layer.
/// Immutable after construction; may be asked from any thread.
class EdgeGrid {
 public:
  explicit EdgeGrid(const geom::Regions& regions);

  bool contains(const geom::Point& p) const;
  /// Whether the straight line runs inside from end to end.
  bool contains(const geom::Point& a, const geom::Point& b) const;
  /// Cuts the line where it crosses the border; neighbouring pieces share their end point.
  std::vector<Piece> split(const geom::Polyline& line) const;

 private:
  struct Edge {
    geom::Point a;
    geom::Point b;
  };
  std::int32_t column(double x) const;
  std::int32_t row(double y) const;
  /// Calls visit(first column, last column, row) for the cells near the segment.
  template <class Visit>
  void walk(const geom::Point& a, const geom::Point& b, Visit visit) const;
  /// Positions in (0, 1) along a → b where an edge is crossed, ascending, without doubles.
  void crossings(const geom::Point& a, const geom::Point& b, std::vector<double>& out) const;

  std::vector<Edge> edges_;
  geom::Box box_{};
  double cell_ = 1;  ///< nm
  std::int32_t columns_ = 0;
  std::int32_t rows_ = 0;
  std::vector<std::uint32_t> start_;  ///< of each cell's edges in items_
  std::vector<std::uint32_t> items_;
};

}  // namespace voidpath::toolpath

#pragma once

#include "engine/geom/polygon.h"

#include <cstdint>
#include <vector>

namespace voidpath::toolpath {

/// The point of the straight line from a to b that is nearest to p.
geom::Point nearest_on_line(const geom::Point& p, const geom::Point& a, const geom::Point& b);

/// Straight lines added one after the other, and the nearest of them to a point.
class LineIndex {
 public:
  struct Hit {
    std::uint32_t line = 0;  ///< in the order of adding
    geom::Point at;          ///< on the line
    double distance = 0;     ///< nm; more than was asked for when nothing is near
  };

  /// For lines and questions within `box`; `cell_nm` should be about the distances asked for.
  LineIndex(const geom::Box& box, geom::Coord cell_nm);

  void add(const geom::Point& a, const geom::Point& b);
  /// Nothing beyond `limit` nm is looked for.
  Hit nearest(const geom::Point& p, double limit) const;
  /// Whether any line is as near as that, nm.
  bool reaches(const geom::Point& p, double distance) const;
  const geom::Box& box() const { return box_; }
  std::size_t size() const { return lines_.size(); }

 private:
  struct Line {
    geom::Point a, b;
  };
  geom::Coord column(geom::Coord x) const;
  geom::Coord row(geom::Coord y) const;

  geom::Box box_;
  geom::Coord cell_;
  geom::Coord columns_;
  geom::Coord rows_;
  std::vector<Line> lines_;
  std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace voidpath::toolpath

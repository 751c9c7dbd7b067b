#pragma once

#include "engine/orient/cross_section.h"

#include <array>
#include <cstdint>
#include <vector>

namespace voidpath::orient {

/// Convex hulls of rings, and quick answers to how far two rings lie apart.
///
/// The hulls' distance bounds the rings' from below and is theirs when it is attained at a corner or on an
/// edge that the ring itself has, as it nearly always is. The search for it follows Gilbert, Johnson and
/// Keerthi (1988) on the difference of the hulls, with extreme corners found by climbing from a table of
/// directions. Keeps its memory.
class HullDistance {
 public:
  void clear();
  /// Adds the hull of ring points[begin, end); returns its number.
  std::size_t add(const std::vector<Point2>& points, std::size_t begin, std::size_t end);

  struct Answer {
    double distance_mm = 0;
    bool exact = false;  ///< also the distance of the rings; false says nothing at all about them
  };
  Answer between(std::size_t a, std::size_t b) const;

 private:
  static constexpr std::size_t kDirections = 16;
  struct Corner {
    Point2 p;
    std::uint32_t place;  ///< index within the ring
    bool straight;        ///< the ring, too, runs straight from here to the next corner
  };
  struct Hull {
    std::uint32_t begin, size;  ///< in corners_
    std::uint32_t ring_size;
    std::array<std::uint32_t, kDirections> extreme;  ///< corner furthest along each direction of the table
  };
  std::uint32_t support(const Hull& h, double dx, double dy) const;
  bool runs_straight(const Hull& h, std::uint32_t i, const std::vector<Point2>& points, std::size_t begin,
                     bool ccw) const;
  bool is_ring_edge(const Hull& h, std::uint32_t a, std::uint32_t b) const;
  const Corner& corner(const Hull& h, std::uint32_t i) const { return corners_[h.begin + i]; }

  std::vector<Hull> hulls_;
  std::vector<Corner> corners_;
  std::vector<Corner> sorted_;
};

}  // namespace voidpath::orient

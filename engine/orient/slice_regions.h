#pragma once

#include "engine/orient/hull_distance.h"

#include <vector>

namespace voidpath::orient {

/// C and D of one slice.
struct SliceMeasure {
  double regions = 0;
  double mean_distance_mm = 0;  ///< over all pairs; 0 for fewer than two regions
};

/// Counts the regions of a slice and measures the distances between them. Keeps its memory.
class SliceRegions {
 public:
  /// Closed rings that do not cross one another: outer ones counter-clockwise, holes clockwise.
  SliceMeasure measure(const std::vector<Point2>& points, const std::vector<Contour>& contours);
  /// Rings whose regions are told (Contour::region); those of one region may cross.
  SliceMeasure measure_told(const std::vector<Point2>& points, const std::vector<Contour>& contours);

 private:
  struct Box {
    double x0, y0, x1, y1;
  };
  struct Ring {
    std::size_t begin, end;  ///< in points
    double area;             ///< signed
    std::size_t tree;        ///< its first box in boxes_
    std::size_t leaves;      ///< a power of two
    Box box;
    std::size_t hull;  ///< in hulls_
  };
  Ring make_ring(const Contour& c);
  Box node(const Ring& r, std::size_t i) const { return boxes_[r.tree + i]; }
  double distance(const Ring& a, const Ring& b);
  double leaf_distance2(const Ring& a, std::size_t leaf_a, const Ring& b, std::size_t leaf_b,
                        double best2) const;
  bool inside(const Ring& ring, Point2 p) const;
  double region_distance(const Ring& a, const Ring& b);
  void start(const std::vector<Point2>& points);

  const std::vector<Point2>* points_ = nullptr;
  std::vector<Ring> outer_, holes_;
  /// Of regions that are told: the rings of their outlines first, then those within.
  struct Told {
    std::vector<Ring> rings;
    std::size_t outline = 0;
    Box box;
  };
  double told_distance(const Told& a, const Told& b);
  std::vector<Told> told_;
  std::vector<Box> boxes_;
  HullDistance hulls_;
  struct NodePair {
    double gap2;
    std::size_t a, b;
  };
  std::vector<NodePair> stack_;
};

}  // namespace voidpath::orient

#pragma once

#include "engine/orient/cross_section.h"

#include <cstdint>
#include <vector>

namespace voidpath::orient {

/// Tells which contours of a slice border what is filled by the non-zero winding rule, and which belong to
/// one region. Contours of sound shells pass through. Where shells meet, no polygons are united, since
/// neither the number of regions nor their distances need their outlines:
///
/// Contours that cross one another make a bundle. Crossing a contour changes the winding number by one, so on
/// one side of it at least is filled: every point of a bundle lies on or in one and the same region. No
/// bundle crosses another, so the winding number around a bundle, which the other bundles make, is the same
/// all along. Where it is nil the bundle lies in the open and begins a region; else it lies within a region,
/// that of whatever bounds the filled face around it, which a line to the left meets first. And a region's
/// border consists of pieces of its contours, none of which leaves it: so the distance of two regions is the
/// least between their contours.
///
/// Bundles that may fill nothing, as a shell and the same inside out do, are left to a union of polygons.
class SliceFill {
 public:
  /// Notes which slices cut through places where shells meet.
  void prepare(const Solid& solid, const Projection& p, const std::vector<Slab>& slabs);

  /// Rewrites the contours of slice i, which has been traced and placed. Returns whether it told the region
  /// of each of them; else each counter-clockwise one is the outline of a region.
  bool settle(std::size_t i, CrossSections& sections);

 private:
  struct Bundle {
    Point2 leftmost, on_edge;    ///< points of it
    double area = 0, areas = 0;  ///< sums of signed and unsigned areas
    Index within = kNone;        ///< bundle whose region it lies in; kNone: begins one
  };
  bool segments_meet(Index t, Index u, double level) const;
  Index bundle_of(Index contour);
  void gather(const std::vector<Contour>& contours, const std::vector<Point2>& points);
  bool nest(const std::vector<Contour>& contours, const std::vector<Point2>& points);

  const Solid* solid_ = nullptr;
  const Projection* p_ = nullptr;
  const std::vector<Slab>* slabs_ = nullptr;
  bool sound_ = true;  ///< nothing to do in any slice
  /// Solid::contacts whose two facets slice i may cut: near_[first_[i]] to near_[first_[i + 1]].
  std::vector<std::size_t> first_;
  std::vector<Index> near_;
  std::vector<Index> joined_;     ///< per contour: another of its bundle, itself for the bundle's first
  std::vector<Index> bundle_at_;  ///< per contour
  std::vector<Bundle> bundles_;
  std::vector<Point2> low_high_;  ///< per contour: lowest and highest y
};

}  // namespace voidpath::orient

#pragma once

#include "engine/orient/cross_section.h"

#include <cstdint>
#include <vector>

namespace voidpath::orient {

/// Makes the contours of slices into borders of what is filled by the non-zero winding rule. Contours of
/// sound shells are that already and pass through; the others take as much work as they need: shells inside
/// material are left out; where shells that meet elsewhere do not cross in this slice, the winding number
/// around each of their contours tells; where they do cross, the polygons are united.
class SliceFill {
 public:
  /// Notes which slices cut through places where shells meet.
  void prepare(const Solid& solid, const Projection& p, const std::vector<Slab>& slabs);

  /// Rewrites contours and points of slice i.
  void settle(std::size_t i, std::vector<Contour>& contours, std::vector<Point2>& points) const;

 private:
  bool contours_cross(std::size_t i) const;

  const Solid* solid_ = nullptr;
  const Projection* p_ = nullptr;
  const std::vector<Slab>* slabs_ = nullptr;
  bool sound_ = true;  ///< nothing to do in any slice
  /// Solid::contacts whose two facets slice i may cut: near_[first_[i]] to near_[first_[i + 1]].
  std::vector<std::size_t> first_;
  std::vector<Index> near_;
};

}  // namespace voidpath::orient

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
  const Solid* solid_ = nullptr;
  bool sound_ = true;  ///< nothing to do in any slice
  std::vector<std::uint8_t> crossed_;
};

}  // namespace voidpath::orient

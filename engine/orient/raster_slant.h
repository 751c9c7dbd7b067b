#pragma once

#include "engine/orient/solid.h"

#include <vector>

namespace voidpath::orient {

struct Projection;

/// How the rows of a raster should run across a part so that few of its edges run along them. A strip along
/// the rows that is narrower than the way between two is hit or missed as a whole, and when it is missed no
/// difference between rows tells.
class RasterSlant {
 public:
  explicit RasterSlant(const Solid& solid);

  /// The slope s of rows, which lie along y + s·x = constant, where the part is as wide as deep as 1.
  float best(const Projection& p) const;

 private:
  /// Along the directions in which most edges run; as long as their share of the part's outline, mean over
  /// all lines of sight. mm
  NearColumns edges_;
};

}  // namespace voidpath::orient

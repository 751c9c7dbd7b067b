#pragma once

#include "engine/orient/solid.h"

#include <cstdint>
#include <vector>

namespace voidpath::orient {

/// A part as one direction sees it: heights along it and two coordinates across. mm
struct Projection {
  std::vector<double> x, y, h;
  Vec3 e1 = Vec3::UnitX(), e2 = Vec3::UnitY();  ///< the axes across; e1 × e2 is the direction
  double x_min = 0, x_max = 0, y_min = 0, y_max = 0, h_min = 0, h_max = 0;
};

/// Projects along d. The axes across are turned by an angle that no design uses, so that the rows and
/// columns of a raster run along no edge of a part.
void project(const Solid& solid, const Vec3& d, Projection& out);

struct TrappedVolume {
  double up_mm3 = 0;    ///< V of d
  double down_mm3 = 0;  ///< V of -d
};

/// Volume under the topmost surface less the solid's.
///
/// Per vertical line, the topmost surface's height is the sum of the heights of all up-facing crossings less
/// those hidden beneath it. The first sum is exact: one prism per up-facing facet. Only the second needs a
/// raster of the up-facing surface, and it is zero in every column that material leaves once. A raster's
/// error thus comes from the borders of hidden faces alone, not from silhouettes or slopes: at most half a
/// cell times the border's length times the height hidden, and it is one cell in thousands across the part.
/// The raster is refined while its even and odd rows disagree by more than kRasterTolerance of the bounding
/// volume. For -d the same holds with up and down exchanged; both come out of one pass.
class TrappedVolumeRaster {
 public:
  TrappedVolume measure(const Solid& solid, const Projection& p);

 private:
  struct Hidden {
    double even = 0, odd = 0;  ///< sum of the hidden heights over even and odd rows, mm per cell
    double total() const { return even + odd; }
    double disagreement() const { return even - odd; }
  };
  void scan(const Solid& solid, const Projection& p, int cells);
  void scan_triangle(const double x[3], const double y[3], const double h[3], float* buffer, Hidden& hidden,
                     int cells);

  std::vector<float> tops_;     ///< highest up-facing surface above h_min; 0: none
  std::vector<float> bottoms_;  ///< lowest down-facing surface below h_max; 0: none
  Hidden hidden_up_, hidden_down_;
  double prisms_up_ = 0, prisms_down_ = 0;
};

}  // namespace voidpath::orient

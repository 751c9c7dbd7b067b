#pragma once

#include "engine/orient/raster_rows.h"
#include "engine/orient/raster_slant.h"
#include "engine/orient/solid.h"

#include <cstdint>
#include <vector>

namespace voidpath::orient {

/// A part as one direction sees it: heights along it and two coordinates across. mm
struct Projection {
  std::vector<double> x, y, h;
  Vec3 e1 = Vec3::UnitX(), e2 = Vec3::UnitY(), d = Vec3::UnitZ();  ///< the axes across and the direction
  double x_min = 0, x_max = 0, y_min = 0, y_max = 0, h_min = 0, h_max = 0;
};

/// Projects along d. The axes across are the main axes of the part's surface as seen along d.
void project(const Solid& solid, const Vec3& d, Projection& out);

struct TrappedVolume {
  double up_mm3 = 0;    ///< V of d
  double down_mm3 = 0;  ///< V of -d
};

/// Volume under the topmost surface less the solid's.
///
/// Per vertical line, the topmost surface's height is the sum of the heights of all up-facing crossings less
/// those hidden beneath it. The first sum is exact: one prism per up-facing facet. Only the second needs a
/// raster of the up-facing surface, and it is zero in every column that material leaves once. The raster
/// tells the first sum too, and where it errs there, it errs by much the same in the second: what share of
/// the one error makes the other is told by how they go together from row to row, and is put right (a control
/// variate by regression; Owen, Monte Carlo theory, methods and examples, 8.9).
///
/// What is left comes from the borders of hidden faces, not from slopes: at most half a row times the
/// border's length times the height hidden, and far less for a border that crosses many rows. So rows run
/// where few edges run along them (RasterSlant) and keep step with no pattern (RasterRows). Then errors of
/// rows are as good as independent and their differences tell them; the raster is refined until its standard
/// error, reckoned from that, is below a quarter of what V may be off by: 1 % of it or 0.5 % of the box
/// around the part, as delivered or as seen along d, whichever is smaller. What it may be off by is four
/// standard errors, then. Against dense random lines, over 76 parts and 200 lines of sight each, both ways, V
/// is off by 0.08 of it in the root mean square and by 0.5 at most, on 62 rows in the median and 253 at most;
/// over the 1286 directions of a search, of the fifteen parts richest in patterns, by 0.92 at most. For -d
/// the same holds with up and down exchanged; both come out of one pass.
class TrappedVolumeRaster {
 public:
  /// Keeps a reference.
  explicit TrappedVolumeRaster(const Solid& solid);

  TrappedVolume measure(const Projection& p);

 private:
  /// What one of the two directions sees. Heights are above its plate, mm.
  struct Side {
    std::vector<float> surface;  ///< the topmost, by cell; 0: none
    double prisms_mm3 = 0;       ///< under all its facets, exactly
    std::vector<float> hidden;   ///< hidden heights, mm · cells; four sums to each row
  };
  struct Corner {
    float x, y, h;
    float next_row;  ///< the first row not below it
  };
  struct Edge;
  /// Of heights over the cells of a row, mm: of hidden surface, of all.
  struct RowSums {
    double hidden = 0;
    double all = 0;
  };
  double look(const Projection& p, int rows, TrappedVolume& out);
  void sum_rows(const Side& side);
  double error_of(const Side& side, double box_mm3, double& v_mm3);
  void sum_prisms(const Projection& p);
  void place(const Projection& p, int rows);
  void scan(float tall, int rows);
  void scan_row(const mesh::Triangle& t, float tall);
  void scan_rows(const Corner& a, const Corner& b, const Corner& c, float tall, int first, int last);

  const Solid& solid_;
  RasterSlant slant_;
  int first_rows_ = 0;  ///< of the raster every line is first looked at with
  int cells_ = 0;       ///< to a row
  RasterRows rows_;
  Side up_, down_;
  std::vector<Corner> corners_;          ///< per vertex, in raster coordinates
  std::vector<std::int16_t> next_rows_;  ///< Corner::next_row, small enough to stay at hand
  std::vector<RowSums> sums_;            ///< with RasterRows::kEmptyAround rows at either end
  double cell_mm2_ = 0;
};

}  // namespace voidpath::orient

#pragma once

#include <array>
#include <vector>

namespace voidpath::orient {

/// Where the rows of a raster lie, and the lines down the cells of each. Neither keeps step with any pattern
/// of a part: what repeats as often as rows do would be hit or missed by all alike.
struct RasterRows {
  /// Nothing but empty rows lies before the first and after the last.
  static constexpr int kEmptyAround = 3;

  void lay(int count);

  std::vector<float> y;        ///< of row j, between j and j + 1; four more follow, for readers of four
  std::vector<float> shift;    ///< x of the line down the first cell, less than 1; four more follow
  std::vector<double> weight;  ///< of a row in an integral over y: half the way from the last to the next
  /// Per four neighbours, beginning with kEmptyAround empty rows: factors that leave nothing of a parabola,
  /// and of independent errors of variance e² one of variance e².
  std::vector<std::array<double, 4>> thirds;
};

}  // namespace voidpath::orient

#pragma once

#include "engine/mesh/triangle_mesh.h"

#include <cstddef>
#include <vector>

namespace voidpath::report {

/// Empty space between material above and the plate or material below. mm above the plate
struct Gap {
  float bottom = 0;
  float top = 0;
  bool overhang = false;  ///< what covers it needs support, and is wide enough not to hold by itself
};

/// The empty space under a part that stands on z = 0, on a grid of columns: for pictures, not for measuring.
class VoidColumns {
 public:
  VoidColumns(const mesh::TriangleMesh& standing, double overhang_deg);

  int width() const { return width_; }
  int depth() const { return depth_; }
  double cell_mm() const { return cell_; }
  double x(int i) const { return x0_ + i * cell_; }  ///< left border of column i
  double y(int j) const { return y0_ + j * cell_; }

  struct Range {
    const Gap* first;
    const Gap* last;
    const Gap* begin() const { return first; }
    const Gap* end() const { return last; }
  };
  /// Lowest first; empty outside of the grid.
  Range gaps(int i, int j) const;

  /// Of gaps under overhangs only. mm³
  double support_mm3() const;
  /// Empty area under material in each of `count` equal layers up to the height. mm²
  std::vector<double> area_by_height(double height_mm, std::size_t count) const;

 private:
  void drop_lips();
  template <class Test>
  int count_around(int i, int j, const Gap& gap, int reach, Test&& test) const;
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(i);
  }

  int width_ = 0, depth_ = 0;
  double cell_ = 1, x0_ = 0, y0_ = 0;
  std::vector<std::size_t> begin_;  ///< per column, one more at the end
  std::vector<Gap> gaps_;
};

/// Whether each facet leans out further than `overhang_deg` from the vertical and is off the plate.
std::vector<bool> find_overhangs(const mesh::TriangleMesh& standing, double overhang_deg);

}  // namespace voidpath::report

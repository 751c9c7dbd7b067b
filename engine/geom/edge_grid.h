#pragma once

#include "engine/geom/polygon.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace voidpath::geom {

struct Edge {
  Point a;
  Point b;
};

Box box_of(const Edge& edge);
/// All edges of the rings in order, from each ring's last corner on.
std::vector<Edge> edges_of(const Rings& rings);

/// Edges sorted into square cells of about their mean length. An edge is in every cell it passes and may be
/// in a few it only comes near to.
class EdgeGrid {
 public:
  explicit EdgeGrid(std::span<const Edge> edges);

  std::size_t cell_count() const { return first_.size() - 1; }
  /// Indices of the edges in a cell, ascending.
  std::span<const std::uint32_t> cell(std::size_t i) const {
    return {items_.data() + first_[i], items_.data() + first_[i + 1]};
  }
  /// Calls visit(cell index) for every cell that a line from a to b may pass, some perhaps that it only
  /// comes near to. Outside the grid there are no cells.
  template <class Visit>
  void along(const Point& a, const Point& b, const Visit& visit) const;
  /// The cells right of p in p's row, p's own included; empty outside the grid's rows.
  template <class Visit>
  void right_of(const Point& p, const Visit& visit) const;

 private:
  Coord column(Coord x) const { return (x - box_.min.x) / size_; }
  Coord row(Coord y) const { return (y - box_.min.y) / size_; }

  Box box_;
  Coord size_ = 1;  ///< of a cell, nm
  Coord columns_ = 0;
  Coord rows_ = 0;
  std::vector<std::uint32_t> first_{0};
  std::vector<std::uint32_t> items_;
};

template <class Visit>
void EdgeGrid::along(const Point& a, const Point& b, const Visit& visit) const {
  if (columns_ == 0) return;
  const Box box = box_of({a, b});
  if (box.max.x < box_.min.x || box.min.x > box_.max.x || box.max.y < box_.min.y || box.min.y > box_.max.y)
    return;
  const Coord row_first = std::max<Coord>(row(std::max(box.min.y, box_.min.y)), 0);
  const Coord row_last = row(std::min(box.max.y, box_.max.y));
  const double slope = a.y == b.y ? 0 : static_cast<double>(b.x - a.x) / static_cast<double>(b.y - a.y);
  for (Coord r = row_first; r <= row_last; ++r) {
    Coord left = box.min.x;
    Coord right = box.max.x;
    if (row_first != row_last) {
      // Where the line enters and leaves the row, a nm wider on both sides than rounding may err.
      constexpr double kRoundingNm = 2;
      const Coord low = std::max(box.min.y, box_.min.y + r * size_);
      const Coord high = std::min(box.max.y, box_.min.y + (r + 1) * size_);
      const double x0 = static_cast<double>(a.x) + slope * static_cast<double>(low - a.y);
      const double x1 = static_cast<double>(a.x) + slope * static_cast<double>(high - a.y);
      left = std::max(left, static_cast<Coord>(std::min(x0, x1) - kRoundingNm));
      right = std::min(right, static_cast<Coord>(std::max(x0, x1) + kRoundingNm));
    }
    if (right < box_.min.x || left > box_.max.x) continue;
    const Coord first = column(std::max(left, box_.min.x));
    const Coord last = column(std::min(right, box_.max.x));
    for (Coord c = first; c <= last; ++c) visit(static_cast<std::size_t>(r * columns_ + c));
  }
}

template <class Visit>
void EdgeGrid::right_of(const Point& p, const Visit& visit) const {
  if (columns_ == 0 || p.y < box_.min.y || p.y > box_.max.y || p.x > box_.max.x) return;
  const Coord r = row(p.y);
  for (Coord c = p.x < box_.min.x ? 0 : column(p.x); c < columns_; ++c)
    visit(static_cast<std::size_t>(r * columns_ + c));
}

}  // namespace voidpath::geom

#include "engine/geom/edge_grid.h"

#include <algorithm>
#include <cmath>

namespace voidpath::geom {

namespace {

/// Cells for each edge at most: an outline of few long edges needs no fine grid.
constexpr double kCellsPerEdge = 2;

}  // namespace

Box box_of(const Edge& e) {
  return {{std::min(e.a.x, e.b.x), std::min(e.a.y, e.b.y)}, {std::max(e.a.x, e.b.x), std::max(e.a.y, e.b.y)}};
}

std::vector<Edge> edges_of(const Rings& rings) {
  std::size_t count = 0;
  for (const Ring& ring : rings) count += ring.size();
  std::vector<Edge> edges;
  edges.reserve(count);
  for (const Ring& ring : rings) {
    if (ring.empty()) continue;
    Point a = ring.back();
    for (const Point& b : ring) {
      edges.push_back({a, b});
      a = b;
    }
  }
  return edges;
}

EdgeGrid::EdgeGrid(std::span<const Edge> edges) {
  if (edges.empty()) return;
  box_ = box_of(edges.front());
  double sum = 0;
  for (const Edge& e : edges) {
    const Box b = box_of(e);
    box_.min = {std::min(box_.min.x, b.min.x), std::min(box_.min.y, b.min.y)};
    box_.max = {std::max(box_.max.x, b.max.x), std::max(box_.max.y, b.max.y)};
    sum += static_cast<double>(b.max.x - b.min.x + b.max.y - b.min.y);
  }
  const auto n = static_cast<double>(edges.size());
  const auto width = static_cast<double>(box_.max.x - box_.min.x) + 1;
  const auto height = static_cast<double>(box_.max.y - box_.min.y) + 1;
  const double cells = kCellsPerEdge * n;
  // Of the mean length, but no more cells than wanted, on thin strips neither.
  const double size =
      std::max({sum / n, std::sqrt(width * height / cells), std::max(width, height) / cells, 1.0});
  size_ = static_cast<Coord>(std::ceil(size));
  columns_ = column(box_.max.x) + 1;
  rows_ = row(box_.max.y) + 1;

  std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;  // cell, edge
  entries.reserve(2 * edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i)
    along(edges[i].a, edges[i].b, [&](std::size_t c) {
      entries.emplace_back(static_cast<std::uint32_t>(c), static_cast<std::uint32_t>(i));
    });
  first_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const auto& entry : entries) ++first_[entry.first + 1];
  for (std::size_t c = 0; c + 1 < first_.size(); ++c) first_[c + 1] += first_[c];
  items_.resize(entries.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (const auto& entry : entries) items_[next[entry.first]++] = entry.second;
}

}  // namespace voidpath::geom

#include "engine/toolpath/line_index.h"

#include <algorithm>
#include <cmath>

namespace voidpath::toolpath {

namespace {

using geom::Coord;
using geom::Point;

/// Cells along a side of the box at most.
constexpr Coord kMaxCells = 400;

double squared_distance(const Point& p, const Point& a, const Point& b) {
  const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
  const auto px = static_cast<double>(p.x - a.x), py = static_cast<double>(p.y - a.y);
  const double len2 = dx * dx + dy * dy;
  const double t = len2 > 0 ? std::clamp((px * dx + py * dy) / len2, 0.0, 1.0) : 0;
  const double x = px - t * dx, y = py - t * dy;
  return x * x + y * y;
}

}  // namespace

Point nearest_on_line(const Point& p, const Point& a, const Point& b) {
  const auto dx = static_cast<double>(b.x - a.x), dy = static_cast<double>(b.y - a.y);
  const double len2 = dx * dx + dy * dy;
  if (len2 <= 0) return a;
  const double along = (static_cast<double>(p.x - a.x) * dx + static_cast<double>(p.y - a.y) * dy) / len2;
  const double t = std::clamp(along, 0.0, 1.0);
  return {a.x + std::llround(t * dx), a.y + std::llround(t * dy)};
}

LineIndex::LineIndex(const geom::Box& box, Coord cell_nm) : box_(box) {
  const Coord size = std::max(box.max.x - box.min.x, box.max.y - box.min.y);
  cell_ = std::max<Coord>({cell_nm, size / kMaxCells, 1});
  columns_ = (box.max.x - box.min.x) / cell_ + 1;
  rows_ = (box.max.y - box.min.y) / cell_ + 1;
  cells_.resize(static_cast<std::size_t>(columns_ * rows_));
}

Coord LineIndex::column(Coord x) const {
  return std::clamp<Coord>((x - box_.min.x) / cell_, 0, columns_ - 1);
}
Coord LineIndex::row(Coord y) const { return std::clamp<Coord>((y - box_.min.y) / cell_, 0, rows_ - 1); }

void LineIndex::add(const Point& a, const Point& b) {
  const auto id = static_cast<std::uint32_t>(lines_.size());
  lines_.push_back({a, b});
  const Point &low = a.y <= b.y ? a : b, &high = a.y <= b.y ? b : a;
  const Coord first = row(low.y), last = row(high.y);
  const double slope =
      high.y > low.y ? static_cast<double>(high.x - low.x) / static_cast<double>(high.y - low.y) : 0;
  const auto x_at = [&](Coord y) { return low.x + std::llround(slope * static_cast<double>(y - low.y)); };
  for (Coord r = first; r <= last; ++r) {
    // Rounding may move a crossing by a nanometre.
    const Coord from = r == first ? low.x : x_at(box_.min.y + r * cell_);
    const Coord to = r == last ? high.x : x_at(box_.min.y + (r + 1) * cell_);
    const Coord end = column(std::max(from, to) + 1);
    for (Coord c = column(std::min(from, to) - 1); c <= end; ++c)
      cells_[static_cast<std::size_t>(r * columns_ + c)].push_back(id);
  }
}

LineIndex::Hit LineIndex::nearest(const Point& p, double limit) const {
  Hit best;
  best.distance = std::nextafter(limit, 2 * limit + 1);
  const Coord cx = column(p.x), cy = row(p.y);
  auto look = [&](Coord x, Coord y) {
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return;
    for (const std::uint32_t id : cells_[static_cast<std::size_t>(y * columns_ + x)]) {
      const Point at = nearest_on_line(p, lines_[id].a, lines_[id].b);
      const double d = geom::distance(p, at);
      if (d < best.distance || (d == best.distance && id < best.line)) best = {id, at, d};
    }
  };
  const Coord most = std::max(columns_, rows_);
  for (Coord r = 0; r <= most; ++r) {
    // What lies in ring r is at least r - 1 cells away.
    if (static_cast<double>(std::max<Coord>(r - 1, 0)) * static_cast<double>(cell_) > best.distance) break;
    for (Coord x = cx - r; x <= cx + r; ++x) {
      look(x, cy - r);
      if (r > 0) look(x, cy + r);
    }
    for (Coord y = cy - r + 1; y < cy + r; ++y) {
      look(cx - r, y);
      look(cx + r, y);
    }
  }
  return best;
}

bool LineIndex::reaches(const Point& p, double distance) const {
  const auto reach = static_cast<Coord>(std::ceil(distance));
  const double limit = distance * distance;
  const Coord right = column(p.x + reach), top = row(p.y + reach);
  for (Coord y = row(p.y - reach); y <= top; ++y)
    for (Coord x = column(p.x - reach); x <= right; ++x)
      for (const std::uint32_t id : cells_[static_cast<std::size_t>(y * columns_ + x)])
        if (squared_distance(p, lines_[id].a, lines_[id].b) <= limit) return true;
  return false;
}

}  // namespace voidpath::toolpath

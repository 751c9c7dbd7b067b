#include "engine/toolpath/line_index.h"

#include <algorithm>
#include <cmath>

namespace voidpath::toolpath {

namespace {

using geom::Coord;
using geom::Point;

/// Cells along a side of the box at most.
constexpr Coord kMaxCells = 400;

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
  // Steps of half a cell touch every cell the line passes or one beside it; questions look one cell further.
  const double length = geom::distance(a, b);
  const auto steps = static_cast<Coord>(std::ceil(2 * length / static_cast<double>(cell_)));
  std::size_t last = cells_.size();
  for (Coord k = 0; k <= steps; ++k) {
    const double t = steps > 0 ? static_cast<double>(k) / static_cast<double>(steps) : 0;
    const Coord x = a.x + std::llround(t * static_cast<double>(b.x - a.x));
    const Coord y = a.y + std::llround(t * static_cast<double>(b.y - a.y));
    const auto at = static_cast<std::size_t>(row(y) * columns_ + column(x));
    if (at != last) cells_[at].push_back(id);
    last = at;
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
    // What lies in ring r is at least r - 1 cells away; a line may be filed one cell beside its place.
    if (static_cast<double>(std::max<Coord>(r - 2, 0)) * static_cast<double>(cell_) > best.distance) break;
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
  auto found = [&](Coord x, Coord y) {
    if (x < 0 || y < 0 || x >= columns_ || y >= rows_) return false;
    const auto& cell = cells_[static_cast<std::size_t>(y * columns_ + x)];
    return std::any_of(cell.begin(), cell.end(), [&](std::uint32_t id) {
      return geom::distance(p, nearest_on_line(p, lines_[id].a, lines_[id].b)) <= distance;
    });
  };
  const Coord cx = column(p.x), cy = row(p.y);
  if (found(cx, cy)) return true;
  // A line may be filed one cell beside its place.
  const Coord reach = static_cast<Coord>(distance) / cell_ + 2;
  for (Coord y = cy - reach; y <= cy + reach; ++y)
    for (Coord x = cx - reach; x <= cx + reach; ++x)
      if ((x != cx || y != cy) && found(x, y)) return true;
  return false;
}

}  // namespace voidpath::toolpath

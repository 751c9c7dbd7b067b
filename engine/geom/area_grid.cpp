#include "engine/geom/area_grid.h"

#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace voidpath::geom {

namespace {

/// Two crossings nearer than this share of the line are one place: the line passes a corner.
constexpr double kSameCrossing = 1e-9;

Point between(const Point& a, const Point& b, double t) {
  return {a.x + std::llround(static_cast<double>(b.x - a.x) * t),
          a.y + std::llround(static_cast<double>(b.y - a.y) * t)};
}

}  // namespace

AreaGrid::AreaGrid(const Regions& regions) : edges_(edges_of(rings_of(regions))), grid_(edges_) {}

bool AreaGrid::contains(const Point& p) const {
  bool inside = false;
  std::span<const std::uint32_t> before;  // an edge is in neighbouring cells of a row, or in one
  grid_.right_of(p, [&](std::size_t c) {
    const std::span<const std::uint32_t> cell = grid_.cell(c);
    for (const std::uint32_t i : cell) {
      const Edge& e = edges_[i];
      if ((e.a.y > p.y) == (e.b.y > p.y)) continue;
      if ((orientation(e.a, e.b, p) > 0) != (e.b.y > e.a.y)) continue;
      if (!std::binary_search(before.begin(), before.end(), i)) inside = !inside;
    }
    before = cell;
  });
  return inside;
}

void AreaGrid::crossings(const Point& a, const Point& b, std::vector<Crossing>& out) const {
  out.clear();
  if (edges_.empty()) return;
  const Box box = box_of({a, b});
  grid_.along(a, b, [&](std::size_t c) {
    for (const std::uint32_t i : grid_.cell(c)) {
      const Edge& e = edges_[i];
      if (!overlap(box_of(e), box)) continue;
      if ((orientation(a, b, e.a) > 0) == (orientation(a, b, e.b) > 0)) continue;
      const Point d{e.b.x - e.a.x, e.b.y - e.a.y};
      const auto from = static_cast<double>(cross(d, {a.x - e.a.x, a.y - e.a.y}));
      const auto to = static_cast<double>(cross(d, {b.x - e.a.x, b.y - e.a.y}));
      if (from == to) continue;
      const double t = from / (from - to);
      if (t > 0 && t < 1) out.push_back({t, i});
    }
  });
  std::sort(out.begin(), out.end(),
            [](const Crossing& s, const Crossing& t) { return s.t != t.t ? s.t < t.t : s.edge < t.edge; });
  out.erase(std::unique(out.begin(), out.end(),
                        [](const Crossing& s, const Crossing& t) { return s.edge == t.edge; }),
            out.end());
}

bool AreaGrid::contains(const Point& a, const Point& b) const {
  std::vector<Crossing> cuts;
  crossings(a, b, cuts);
  return cuts.empty() && contains(between(a, b, 0.5));
}

std::vector<Piece> AreaGrid::split(const Polyline& line) const {
  std::vector<Piece> out;
  std::vector<Crossing> cuts;
  auto extend = [&](const Point& from, const Point& to, bool inside) {
    if (from == to) return;
    if (out.empty() || out.back().inside != inside) out.push_back({{from}, inside});
    out.back().points.push_back(to);
  };
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Point& a = line[i];
    const Point& b = line[i + 1];
    crossings(a, b, cuts);
    Point from = a;
    double at = 0;
    for (std::size_t c = 0; c <= cuts.size(); ++c) {
      const double end = c < cuts.size() ? cuts[c].t : 1.0;
      if (c < cuts.size() && end - at < kSameCrossing) continue;
      const Point to = c < cuts.size() ? between(a, b, end) : b;
      extend(from, to, contains(between(a, b, 0.5 * (at + end))));
      from = to;
      at = end;
    }
  }
  return out;
}

}  // namespace voidpath::geom

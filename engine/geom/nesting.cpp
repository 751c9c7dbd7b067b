#include "engine/geom/nesting.h"

#include "engine/geom/edge_grid.h"
#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace voidpath::geom {

namespace {

/// Whether two edges have any point in common.
bool touch(const Edge& s, const Edge& t) {
  if (!overlap(box_of(s), box_of(t))) return false;
  if (orientation(s.a, s.b, t.a) * orientation(s.a, s.b, t.b) > 0) return false;
  return orientation(t.a, t.b, s.a) * orientation(t.a, t.b, s.b) <= 0;
}

/// Whether b, which starts where a ends, runs back along it.
bool folds_back(const Edge& a, const Edge& b) {
  const Point u{a.b.x - a.a.x, a.b.y - a.a.y};
  const Point v{b.b.x - b.a.x, b.b.y - b.a.y};
  return cross(u, v) == 0 && static_cast<Wide>(u.x) * v.x + static_cast<Wide>(u.y) * v.y <= 0;
}

bool is_filled(int winding, FillRule rule) {
  switch (rule) {
    case FillRule::even_odd:
      return winding % 2 != 0;
    case FillRule::positive:
      return winding > 0;
    case FillRule::non_zero:
      break;
  }
  return winding != 0;
}

struct Nested {
  const Ring* ring = nullptr;
  Box box;
  double area = 0;
  std::vector<std::size_t> inside_of;  ///< rings that contain this one
  bool is_border = false;
  bool is_outer = false;
};

bool encloses(const Box& a, const Box& b) {
  return a.min.x <= b.min.x && a.min.y <= b.min.y && a.max.x >= b.max.x && a.max.y >= b.max.y;
}

std::vector<Nested> nest(const Rings& rings) {
  std::vector<Nested> all(rings.size());
  for (std::size_t i = 0; i < rings.size(); ++i)
    all[i] = {&rings[i], *bounds(rings[i]), area(rings[i]), {}, false, false};
  std::vector<std::size_t> by_left(all.size());
  for (std::size_t i = 0; i < by_left.size(); ++i) by_left[i] = i;
  std::sort(by_left.begin(), by_left.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(all[a].box.min.x, a) < std::pair(all[b].box.min.x, b);
  });
  // Rings that may enclose the one at hand: begun left of it and not yet over.
  std::vector<std::size_t> active;
  for (const std::size_t i : by_left) {
    std::erase_if(active, [&](std::size_t a) { return all[a].box.max.x < all[i].box.min.x; });
    for (const std::size_t a : active) {
      if (encloses(all[a].box, all[i].box) && contains(*all[a].ring, all[i].ring->front()))
        all[i].inside_of.push_back(a);
      else if (encloses(all[i].box, all[a].box) && contains(*all[i].ring, all[a].ring->front()))
        all[a].inside_of.push_back(i);
    }
    active.push_back(i);
  }
  return all;
}

Ring oriented(const Ring& ring, bool reversed) { return reversed ? Ring(ring.rbegin(), ring.rend()) : ring; }

}  // namespace

bool any_edges_touch(const Rings& rings) {
  const std::vector<Edge> edges = edges_of(rings);
  // next[i]: the edge that follows i in its ring.
  std::vector<std::uint32_t> next(edges.size());
  std::uint32_t first = 0;
  for (const Ring& ring : rings) {
    const auto n = static_cast<std::uint32_t>(ring.size());
    if (n == 0) continue;
    if (n < 3) return true;
    for (std::uint32_t k = 0; k < n; ++k) {
      next[first + k] = first + (k + 1) % n;
      if (folds_back(edges[first + k], edges[next[first + k]])) return true;
    }
    first += n;
  }
  const EdgeGrid grid(edges);
  for (std::size_t c = 0; c < grid.cell_count(); ++c) {
    const auto cell = grid.cell(c);
    for (std::size_t i = 0; i < cell.size(); ++i)
      for (std::size_t k = i + 1; k < cell.size(); ++k) {
        if (next[cell[i]] == cell[k] || next[cell[k]] == cell[i]) continue;
        if (touch(edges[cell[i]], edges[cell[k]])) return true;
      }
  }
  return false;
}

std::optional<Regions> nest_if_disjoint(const Rings& rings, FillRule rule) {
  if (rings.empty()) return Regions{};
  for (const Ring& ring : rings)
    if (ring.size() < 3) return std::nullopt;
  if (any_edges_touch(rings)) return std::nullopt;

  std::vector<Nested> all = nest(rings);
  for (Nested& n : all) {
    int outside = 0;
    for (const std::size_t a : n.inside_of) outside += all[a].area > 0 ? 1 : -1;
    const int inside = outside + (n.area > 0 ? 1 : -1);
    n.is_outer = is_filled(inside, rule);
    n.is_border = n.is_outer != is_filled(outside, rule);
  }
  Regions out;
  std::vector<std::size_t> region_of(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].is_border || !all[i].is_outer) continue;
    region_of[i] = out.size();
    out.push_back({oriented(*all[i].ring, all[i].area < 0), {}});
  }
  for (const Nested& n : all) {
    if (!n.is_border || n.is_outer) continue;
    // The innermost border around a hole is the outer ring of its region.
    const Nested* around = nullptr;
    for (const std::size_t a : n.inside_of)
      if (all[a].is_border && (around == nullptr || std::abs(all[a].area) < std::abs(around->area)))
        around = &all[a];
    out[region_of[static_cast<std::size_t>(around - all.data())]].holes.push_back(
        oriented(*n.ring, n.area > 0));
  }
  return out;
}

}  // namespace voidpath::geom

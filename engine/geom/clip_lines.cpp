#include "engine/geom/polygon_ops.h"
#include "engine/geom/predicates.h"

#include <algorithm>
#include <cmath>

/// Open lines against filled areas, by parity. All lines are thought moved by the same infinitesimal
/// step (e, e²), e > 0, so that no line meets a corner or runs along an edge (simulation of simplicity,
/// Edelsbrunner and Mücke 1990): every crossing is found or not found by exact signs, and inside and
/// outside add up to the whole line.
namespace voidpath::geom {

namespace {

struct Edge {
  Point a;
  Point b;
  Box box;
};

Box box_of(const Point& a, const Point& b) {
  return {{std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(a.x, b.x), std::max(a.y, b.y)}};
}

/// Sign of u × (e, e²).
int cross_with_step(const Point& u) {
  if (u.y != 0) return u.y > 0 ? -1 : 1;
  return u.x > 0 ? 1 : u.x < 0 ? -1 : 0;
}

/// Side of the still corner v as seen from the moved line p→q.
int side_of_corner(const Point& p, const Point& q, const Point& v) {
  const int s = orientation(p, q, v);
  return s != 0 ? s : -cross_with_step({q.x - p.x, q.y - p.y});
}

/// Side of the moved point p as seen from the still edge.
int side_of_moved(const Edge& edge, const Point& p) {
  const int s = orientation(edge.a, edge.b, p);
  return s != 0 ? s : cross_with_step({edge.b.x - edge.a.x, edge.b.y - edge.a.y});
}

/// Parity of the moved point: edges crossed by the ray from it along +x.
bool is_inside(const std::vector<Edge>& edges, const Point& p) {
  bool inside = false;
  for (const Edge& e : edges) {
    // The step lifts p by e² > 0: a corner at p's height lies below the ray.
    if ((e.a.y <= p.y) == (e.b.y <= p.y)) continue;
    if ((side_of_moved(e, p) > 0) == (e.b.y > e.a.y)) inside = !inside;
  }
  return inside;
}

/// Where p→q is crossed by the edge, as a fraction of it.
double fraction(const Point& p, const Point& q, const Edge& e) {
  const Point d{e.b.x - e.a.x, e.b.y - e.a.y};
  const auto from = static_cast<double>(cross(d, {p.x - e.a.x, p.y - e.a.y}));
  const auto to = static_cast<double>(cross(d, {q.x - e.a.x, q.y - e.a.y}));
  return from == to ? 0.5 : std::clamp(from / (from - to), 0.0, 1.0);
}

Point at(const Point& p, const Point& q, double t) {
  if (t >= 1) return q;
  return {p.x + std::llround(t * static_cast<double>(q.x - p.x)),
          p.y + std::llround(t * static_cast<double>(q.y - p.y))};
}

/// Collects pieces; a piece without length is none.
class Pieces {
 public:
  void extend(const Point& p) {
    if (piece_.empty() || piece_.back() != p) piece_.push_back(p);
  }
  void end() {
    if (piece_.size() > 1) done_.push_back(std::move(piece_));
    piece_.clear();
  }
  Polylines take() { return std::move(done_); }

 private:
  Polyline piece_;
  Polylines done_;
};

std::vector<Edge> edges_of(const Regions& regions) {
  std::vector<Edge> edges;
  for (const Ring& ring : rings_of(regions)) {
    if (ring.empty()) continue;
    Point a = ring.back();
    for (const Point& b : ring) {
      if (a != b) edges.push_back({a, b, box_of(a, b)});
      a = b;
    }
  }
  return edges;
}

Polylines clip(const Polylines& lines, const Regions& regions, bool want_inside) {
  const std::vector<Edge> edges = edges_of(regions);
  Pieces pieces;
  std::vector<double> crossings;
  for (const Polyline& line : lines) {
    if (line.size() < 2) continue;
    bool wanted = is_inside(edges, line.front()) == want_inside;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Point& p = line[i];
      const Point& q = line[i + 1];
      if (p == q) continue;
      if (wanted) pieces.extend(p);
      const Box box = box_of(p, q);
      crossings.clear();
      for (const Edge& e : edges) {
        if (!overlap(e.box, box)) continue;
        if (side_of_corner(p, q, e.a) == side_of_corner(p, q, e.b)) continue;
        if (side_of_moved(e, p) == side_of_moved(e, q)) continue;
        crossings.push_back(fraction(p, q, e));
      }
      std::sort(crossings.begin(), crossings.end());
      for (const double t : crossings) {
        pieces.extend(at(p, q, t));
        if (wanted) pieces.end();
        wanted = !wanted;
      }
      if (wanted) pieces.extend(q);
    }
    pieces.end();
  }
  return pieces.take();
}

}  // namespace

Polylines clip_inside(const Polylines& lines, const Regions& regions) { return clip(lines, regions, true); }
Polylines clip_outside(const Polylines& lines, const Regions& regions) { return clip(lines, regions, false); }

}  // namespace voidpath::geom

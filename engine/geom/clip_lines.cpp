#include "engine/geom/edge_grid.h"
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

/// Where p→q is crossed by the edge, as a fraction of it.
double fraction(const Point& p, const Point& q, const Edge& e) {
  const Point d{e.b.x - e.a.x, e.b.y - e.a.y};
  const auto from = static_cast<double>(cross(d, {p.x - e.a.x, p.y - e.a.y}));
  const auto to = static_cast<double>(cross(d, {q.x - e.a.x, q.y - e.a.y}));
  return from == to ? 0.5 : std::clamp(from / (from - to), 0.0, 1.0);
}

/// Regions' edges, found by place.
class Outline {
 public:
  explicit Outline(const Regions& regions) : edges_(edges_of(rings_of(regions))), grid_(edges_) {
    seen_.assign(edges_.size(), 0);
  }

  /// Parity of the moved point: edges crossed by the ray from it along +x.
  bool contains(const Point& p) {
    bool inside = false;
    ++visit_;
    grid_.right_of(p, [&](std::size_t c) {
      each_new(c, [&](const Edge& e) {
        // The step lifts p by e² > 0: a corner at p's height lies below the ray.
        if ((e.a.y <= p.y) == (e.b.y <= p.y)) return;
        if ((side_of_moved(e, p) > 0) == (e.b.y > e.a.y)) inside = !inside;
      });
    });
    return inside;
  }

  /// Where p→q crosses, as fractions of it, ascending.
  void crossings(const Point& p, const Point& q, std::vector<double>& out) {
    out.clear();
    ++visit_;
    const Box box = box_of({p, q});
    grid_.along(p, q, [&](std::size_t c) {
      each_new(c, [&](const Edge& e) {
        if (!overlap(box_of(e), box)) return;
        if (side_of_corner(p, q, e.a) == side_of_corner(p, q, e.b)) return;
        if (side_of_moved(e, p) == side_of_moved(e, q)) return;
        out.push_back(fraction(p, q, e));
      });
    });
    std::sort(out.begin(), out.end());
  }

 private:
  /// Each edge once a visit, though it is in several cells.
  template <class Use>
  void each_new(std::size_t cell, const Use& use) {
    for (const std::uint32_t i : grid_.cell(cell)) {
      if (seen_[i] == visit_) continue;
      seen_[i] = visit_;
      use(edges_[i]);
    }
  }

  std::vector<Edge> edges_;
  EdgeGrid grid_;
  std::vector<std::uint32_t> seen_;
  std::uint32_t visit_ = 0;
};

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

Polylines clip(const Polylines& lines, const Regions& regions, bool want_inside) {
  Outline outline(regions);
  Pieces pieces;
  std::vector<double> crossings;
  for (const Polyline& line : lines) {
    if (line.size() < 2) continue;
    bool wanted = outline.contains(line.front()) == want_inside;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const Point& p = line[i];
      const Point& q = line[i + 1];
      if (p == q) continue;
      if (wanted) pieces.extend(p);
      outline.crossings(p, q, crossings);
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

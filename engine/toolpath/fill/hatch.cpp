#include "engine/toolpath/fill/hatch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace voidpath::toolpath {

namespace {

using geom::Coord;
using geom::Point;

/// Rows keep this far from the area's extremes when they are fitted, nm: a row exactly on a border edge
/// would be lost to rounding.
constexpr double kBorderClearance = 1000.0;

/// A border that is this much shorter at its extreme than half a row further in is no edge but a curve or a
/// corner: the first row keeps half a spacing from it, since at the extreme it would be a dot.
constexpr double kEdgeShare = 0.5;

/// In the frame turned so that rows are horizontal, nm.
struct Turned {
  double x;
  double y;
};

/// Where a row meets the border.
struct Hit {
  std::int64_t row = 0;
  double x = 0;
  double along = 0;  ///< length of the border from the ring's first vertex
  std::uint32_t ring = 0;
  std::uint32_t edge = 0;  ///< from vertex `edge` to the next
  std::uint32_t prev = 0;  ///< neighbours on the ring
  std::uint32_t next = 0;
  std::uint32_t mate = 0;  ///< the row's other end
};

class Hatcher {
 public:
  Hatcher(const geom::Regions& domain, const HatchOptions& options)
      : options_(options), cos_(std::cos(options.angle_rad)), sin_(std::sin(options.angle_rad)) {
    for (const auto& region : domain) {
      add(region.outer);
      for (const auto& hole : region.holes) add(hole);
    }
  }

  Hatch run() {
    Hatch out;
    out.spacing_mm = options_.spacing_mm;
    if (rings_.empty() || !(options_.spacing_mm > 0)) return out;
    place_rows();
    out.spacing_mm = spacing_ / geom::kNmPerMm;
    for (std::uint32_t r = 0; r < rings_.size(); ++r) cross(r);
    pair();
    walk(out.lines);
    return out;
  }

 private:
  void add(const geom::Ring& ring) {
    if (ring.size() < 3) return;
    std::vector<Turned> turned;
    turned.reserve(ring.size());
    for (const Point& p : ring) {
      const auto x = static_cast<double>(p.x);
      const auto y = static_cast<double>(p.y);
      turned.push_back({cos_ * x + sin_ * y, cos_ * y - sin_ * x});
      min_y_ = std::min(min_y_, turned.back().y);
      max_y_ = std::max(max_y_, turned.back().y);
    }
    rings_.push_back(std::move(turned));
  }

  void place_rows() {
    spacing_ = options_.spacing_mm * geom::kNmPerMm;
    if (!options_.fit) return;
    const double low = setback(min_y_, 1), high = setback(max_y_, -1);
    const double extent = max_y_ - min_y_ - 2 * kBorderClearance - low - high;
    if (extent <= spacing_ * 0.5) {
      first_ = 0.5 * (min_y_ + max_y_);
      return;
    }
    first_ = min_y_ + kBorderClearance + low;
    double rows = std::floor(extent / spacing_);
    if (rows < 1 || extent / rows > options_.max_stretch * spacing_) rows += 1;
    spacing_ = extent / rows;
  }

  /// How far the outermost row keeps from the area's extreme at y; the area lies on the side of `way`.
  double setback(double y, double way) const {
    const double at_edge = width_at(y + way * kBorderClearance);
    return at_edge < kEdgeShare * width_at(y + way * 0.5 * spacing_) ? 0.5 * spacing_ : 0.0;
  }

  /// Length of a row at y within the area.
  double width_at(double y) const {
    double sum = 0;
    for (const auto& ring : rings_)
      for (std::size_t e = 0; e < ring.size(); ++e) {
        const Turned& a = ring[e];
        const Turned& b = ring[(e + 1) % ring.size()];
        if ((a.y < y) == (b.y < y)) continue;
        const double x = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
        sum += a.y < b.y ? x : -x;
      }
    return std::abs(sum);
  }

  /// The first row at or above y.
  std::int64_t row_above(double y) const {
    return static_cast<std::int64_t>(std::ceil((y - first_) / spacing_ - 1e-9));
  }

  void cross(std::uint32_t r) {
    const auto& ring = rings_[r];
    const auto begin = static_cast<std::uint32_t>(hits_.size());
    double along = 0;
    auto meet = [&](std::int64_t row, const Turned& a, const Turned& b, std::uint32_t edge, double length) {
      const double y = first_ + static_cast<double>(row) * spacing_;
      const double t = std::clamp((y - a.y) / (b.y - a.y), 0.0, 1.0);
      Hit hit;
      hit.row = row;
      hit.x = a.x + t * (b.x - a.x);
      hit.along = along + t * length;
      hit.ring = r;
      hit.edge = edge;
      hits_.push_back(hit);
    };
    for (std::uint32_t e = 0; e < ring.size(); ++e) {
      const Turned& a = ring[e];
      const Turned& b = ring[(e + 1) % ring.size()];
      const double length = std::sqrt((b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y));
      const std::int64_t from = row_above(a.y);
      const std::int64_t to = row_above(b.y);
      for (std::int64_t row = from; row < to; ++row) meet(row, a, b, e, length);
      for (std::int64_t row = from; row-- > to;) meet(row, a, b, e, length);
      along += length;
    }
    lengths_.push_back(along);
    const auto end = static_cast<std::uint32_t>(hits_.size());
    for (std::uint32_t h = begin; h < end; ++h) {
      hits_[h].next = h + 1 < end ? h + 1 : begin;
      hits_[h].prev = h > begin ? h - 1 : end - 1;
    }
  }

  void pair() {
    by_row_.resize(hits_.size());
    std::iota(by_row_.begin(), by_row_.end(), 0u);
    std::sort(by_row_.begin(), by_row_.end(), [&](std::uint32_t a, std::uint32_t b) {
      if (hits_[a].row != hits_[b].row) return hits_[a].row < hits_[b].row;
      if (hits_[a].x != hits_[b].x) return hits_[a].x < hits_[b].x;
      return a < b;
    });
    for (std::size_t i = 0; i + 1 < by_row_.size(); i += 2) {
      hits_[by_row_[i]].mate = by_row_[i + 1];
      hits_[by_row_[i + 1]].mate = by_row_[i];
    }
  }

  double arc(std::uint32_t from, bool forward) const {
    const Hit& h = hits_[from];
    const Hit& o = hits_[forward ? h.next : h.prev];
    const double d = forward ? o.along - h.along : h.along - o.along;
    return d >= 0 ? d : d + lengths_[h.ring];
  }

  Point back(const Turned& p) const {
    return {static_cast<Coord>(std::llround(cos_ * p.x - sin_ * p.y)),
            static_cast<Coord>(std::llround(sin_ * p.x + cos_ * p.y))};
  }
  Point point(std::uint32_t h) const {
    return back({hits_[h].x, first_ + static_cast<double>(hits_[h].row) * spacing_});
  }

  static void append(geom::Polyline& line, const Point& p) {
    if (line.empty() || !(line.back() == p)) line.push_back(p);
  }

  /// The border's vertices between a hit and its neighbour.
  void follow(geom::Polyline& line, std::uint32_t from, bool forward) const {
    const Hit& h = hits_[from];
    const Hit& o = hits_[forward ? h.next : h.prev];
    const auto& ring = rings_[h.ring];
    const auto n = static_cast<std::uint32_t>(ring.size());
    const bool wraps = forward ? o.along < h.along : o.along > h.along;
    std::uint32_t steps = forward ? (o.edge + n - h.edge) % n : (h.edge + n - o.edge) % n;
    if (steps == 0 && wraps) steps = n;
    for (std::uint32_t s = 0; s < steps; ++s)
      append(line, back(ring[forward ? (h.edge + 1 + s) % n : (h.edge + n - s) % n]));
  }

  /// Where to go on from a line's end: the shorter stretch of border that leads to an unused line.
  bool link(std::uint32_t from, const std::vector<bool>& used, bool& forward) const {
    const double limit = options_.max_link_mm * geom::kNmPerMm;
    double best = limit;
    bool found = false;
    for (const bool way : {true, false}) {
      const std::uint32_t to = way ? hits_[from].next : hits_[from].prev;
      if (to == from || used[to]) continue;
      const double d = arc(from, way);
      if (d < best || (d <= best && !found)) {
        best = d;
        forward = way;
        found = true;
      }
    }
    return found;
  }

  void walk(geom::Polylines& out) {
    std::vector<bool> used(hits_.size(), false);
    for (std::size_t i = 0; i + 1 < by_row_.size(); i += 2) {
      std::uint32_t h = by_row_[i];
      if (used[h]) continue;
      geom::Polyline line;
      for (;;) {
        const std::uint32_t end = hits_[h].mate;
        used[h] = used[end] = true;
        append(line, point(h));
        append(line, point(end));
        bool forward = true;
        if (options_.max_link_mm <= 0 || !link(end, used, forward)) break;
        follow(line, end, forward);
        h = forward ? hits_[end].next : hits_[end].prev;
      }
      if (line.size() > 1) out.push_back(std::move(line));
    }
  }

  HatchOptions options_;
  double cos_;
  double sin_;
  double min_y_ = std::numeric_limits<double>::max();
  double max_y_ = std::numeric_limits<double>::lowest();
  double spacing_ = 1;
  double first_ = 0;
  std::vector<std::vector<Turned>> rings_;
  std::vector<double> lengths_;
  std::vector<Hit> hits_;
  std::vector<std::uint32_t> by_row_;
};

}  // namespace

Hatch hatch(const geom::Regions& domain, const HatchOptions& options) {
  return Hatcher(domain, options).run();
}

}  // namespace voidpath::toolpath

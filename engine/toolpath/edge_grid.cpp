#include "engine/toolpath/edge_grid.h"

#include <algorithm>
#include <cmath>

namespace voidpath::toolpath {

namespace {

using geom::Point;

/// Grids larger than this per side gain nothing.
constexpr double kMaxCellsPerSide = 512;
/// Segments are widened by this before cells are looked up, nm, against rounding at cell borders.
constexpr double kCellSlack = 10;
/// Two crossings nearer than this share of the segment are one: the segment passes a corner.
constexpr double kSameCrossing = 1e-9;

double cross(const Point& o, const Point& a, const Point& b) {
  return static_cast<double>(a.x - o.x) * static_cast<double>(b.y - o.y) -
         static_cast<double>(a.y - o.y) * static_cast<double>(b.x - o.x);
}

Point between(const Point& a, const Point& b, double t) {
  return {a.x + std::llround(static_cast<double>(b.x - a.x) * t),
          a.y + std::llround(static_cast<double>(b.y - a.y) * t)};
}

}  // namespace

EdgeGrid::EdgeGrid(const geom::Regions& regions) {
  const auto box = geom::bounds(regions);
  if (!box) return;
  box_ = *box;
  for (const auto& region : regions) {
    auto add = [&](const geom::Ring& ring) {
      for (std::size_t i = 0; i < ring.size(); ++i) edges_.push_back({ring[i], ring[(i + 1) % ring.size()]});
    };
    add(region.outer);
    for (const auto& hole : region.holes) add(hole);
  }
  const auto w = static_cast<double>(box_.max.x - box_.min.x) + 1;
  const auto h = static_cast<double>(box_.max.y - box_.min.y) + 1;
  cell_ =
      std::max(std::sqrt(w * h / static_cast<double>(edges_.size() + 1)), std::max(w, h) / kMaxCellsPerSide);
  columns_ = static_cast<std::int32_t>(w / cell_) + 1;
  rows_ = static_cast<std::int32_t>(h / cell_) + 1;
  start_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  auto each_cell = [&](const Edge& e, auto&& body) {
    walk(e.a, e.b, [&](std::int32_t x0, std::int32_t x1, std::int32_t y) {
      for (std::int32_t x = x0; x <= x1; ++x)
        body(static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x));
      return true;
    });
  };
  for (const Edge& e : edges_) each_cell(e, [&](std::size_t cell) { ++start_[cell + 1]; });
  for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  items_.resize(start_.back());
  std::vector<std::uint32_t> fill(start_.begin(), start_.end() - 1);
  for (std::uint32_t i = 0; i < edges_.size(); ++i)
    each_cell(edges_[i], [&](std::size_t cell) { items_[fill[cell]++] = i; });
}

std::int32_t EdgeGrid::column(double x) const {
  return std::clamp(static_cast<std::int32_t>(std::floor((x - static_cast<double>(box_.min.x)) / cell_)), 0,
                    columns_ - 1);
}
std::int32_t EdgeGrid::row(double y) const {
  return std::clamp(static_cast<std::int32_t>(std::floor((y - static_cast<double>(box_.min.y)) / cell_)), 0,
                    rows_ - 1);
}

template <class Visit>
void EdgeGrid::walk(const Point& a, const Point& b, Visit visit) const {
  const bool up = a.y <= b.y;
  const Point& low = up ? a : b;
  const Point& high = up ? b : a;
  const auto lx = static_cast<double>(low.x);
  const auto ly = static_cast<double>(low.y);
  const double dx = static_cast<double>(high.x) - lx;
  const double dy = static_cast<double>(high.y) - ly;
  const std::int32_t r0 = row(ly - kCellSlack);
  const std::int32_t r1 = row(ly + dy + kCellSlack);
  for (std::int32_t r = r0; r <= r1; ++r) {
    double t0 = 0;
    double t1 = 1;
    if (dy > 0) {
      const double bottom = static_cast<double>(box_.min.y) + r * cell_ - kCellSlack;
      const double top = bottom + cell_ + 2 * kCellSlack;
      if (r > r0) t0 = std::clamp((bottom - ly) / dy, 0.0, 1.0);
      if (r < r1) t1 = std::clamp((top - ly) / dy, 0.0, 1.0);
    }
    const double xa = lx + t0 * dx;
    const double xb = lx + t1 * dx;
    if (!visit(column(std::min(xa, xb) - kCellSlack), column(std::max(xa, xb) + kCellSlack), r)) return;
  }
}

bool EdgeGrid::contains(const Point& p) const {
  if (edges_.empty() || p.x < box_.min.x || p.x > box_.max.x || p.y < box_.min.y || p.y > box_.max.y)
    return false;
  const std::int32_t r = row(static_cast<double>(p.y));
  const std::int32_t last = column(static_cast<double>(p.x) + kCellSlack);
  bool in = false;
  // An edge lies in several cells of the row; the cell that holds its crossing counts it.
  for (std::int32_t c = 0; c <= last; ++c) {
    const std::size_t cell =
        static_cast<std::size_t>(r) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(c);
    for (std::uint32_t k = start_[cell]; k < start_[cell + 1]; ++k) {
      const Edge& e = edges_[items_[k]];
      if ((e.a.y > p.y) == (e.b.y > p.y)) continue;
      const double x = static_cast<double>(e.a.x) +
                       static_cast<double>(e.b.x - e.a.x) *
                           (static_cast<double>(p.y - e.a.y) / static_cast<double>(e.b.y - e.a.y));
      if (column(x) == c && x < static_cast<double>(p.x)) in = !in;
    }
  }
  return in;
}

void EdgeGrid::crossings(const Point& a, const Point& b, std::vector<double>& out) const {
  out.clear();
  if (edges_.empty()) return;
  walk(a, b, [&](std::int32_t x0, std::int32_t x1, std::int32_t y) {
    for (std::int32_t x = x0; x <= x1; ++x) {
      const std::size_t cell =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
      for (std::uint32_t k = start_[cell]; k < start_[cell + 1]; ++k) {
        const Edge& e = edges_[items_[k]];
        const double ca = cross(a, b, e.a);
        const double cb = cross(a, b, e.b);
        if ((ca > 0) == (cb > 0)) continue;
        const double ea = cross(e.a, e.b, a);
        const double eb = cross(e.a, e.b, b);
        if (ea == eb) continue;
        const double t = ea / (ea - eb);
        if (t > 0 && t < 1) out.push_back(t);
      }
    }
    return true;
  });
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end(), [](double s, double t) { return t - s < kSameCrossing; }),
            out.end());
}

bool EdgeGrid::contains(const Point& a, const Point& b) const {
  std::vector<double> cuts;
  crossings(a, b, cuts);
  return cuts.empty() && contains(between(a, b, 0.5));
}

std::vector<Piece> EdgeGrid::split(const geom::Polyline& line) const {
  std::vector<Piece> out;
  std::vector<double> cuts;
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
      const double end = c < cuts.size() ? cuts[c] : 1.0;
      const Point to = c < cuts.size() ? between(a, b, end) : b;
      extend(from, to, contains(between(a, b, 0.5 * (at + end))));
      from = to;
      at = end;
    }
  }
  return out;
}

}  // namespace voidpath::toolpath

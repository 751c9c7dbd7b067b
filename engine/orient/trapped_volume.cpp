#include "engine/orient/trapped_volume.h"

#include <algorithm>
#include <cmath>

namespace voidpath::orient {

namespace {

/// Turn of the raster about the direction, rad: the golden angle.
constexpr double kRasterTurn = 2.399963229728653;
constexpr int kCells = 128;  ///< across the part, each way, to begin with
constexpr int kMostCells = 1024;
/// Share of the bounding volume by which the two halves of the rows may disagree before the raster is
/// refined. The error of their mean is smaller than half of it.
constexpr double kRasterTolerance = 0.004;

/// ceil(v) for what fits an int, without a call.
int ceil_int(double v) {
  const int i = static_cast<int>(v);
  return i + (static_cast<double>(i) < v ? 1 : 0);
}

/// The x of an edge by row, reckoned from its lower end.
struct Edge {
  Edge(const double x[3], const double y[3], int a, int b)
      : x0(x[a]), y0(y[a]), slope(y[b] > y[a] ? (x[b] - x[a]) / (y[b] - y[a]) : 0) {}
  double at(double row) const { return x0 + (row - y0) * slope; }
  double x0, y0, slope;
};

/// Eight cells at once, in whatever registers the machine has; loaded and stored at any address.
typedef float Lanes __attribute__((vector_size(32), aligned(4), may_alias));

/// Lays a strip of surface that rises evenly from za to zb over `count` cells: each keeps the higher, and the
/// lower of the two is hidden. Returns the sum of the hidden heights.
double deposit(float* cell, int count, double za, double zb) {
  const auto z = static_cast<float>(za);
  const auto step = static_cast<float>(count > 1 ? (zb - za) / (count - 1) : 0.0);
  float hidden = 0;
  int i = 0;
  if (count >= 8) {
    Lanes sums = {};
    Lanes level = Lanes{0, 1, 2, 3, 4, 5, 6, 7} * step + z;
    const Lanes stride = Lanes{} + 8 * step;
    for (; i + 8 <= count; i += 8) {
      Lanes& cells = *reinterpret_cast<Lanes*>(cell + i);
      const Lanes old = cells;
      sums += old < level ? old : level;
      cells = old < level ? level : old;
      level += stride;
    }
    for (int k = 0; k < 8; ++k) hidden += sums[k];
  }
  for (; i < count; ++i) {
    const float level = z + step * static_cast<float>(i);
    hidden += std::min(cell[i], level);
    cell[i] = std::max(cell[i], level);
  }
  return static_cast<double>(hidden);
}

}  // namespace

void project(const Solid& solid, const Vec3& d, Projection& out) {
  const Vec3 a = std::abs(d.x()) < 0.6 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 u = (a - d * d.dot(a)).normalized();
  const Vec3 v = d.cross(u);
  const Vec3 e1 = std::cos(kRasterTurn) * u + std::sin(kRasterTurn) * v;
  const Vec3 e2 = d.cross(e1);
  out.e1 = e1;
  out.e2 = e2;
  const std::size_t n = solid.vertices.size();
  out.x.resize(n);
  out.y.resize(n);
  out.h.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& p = solid.vertices[i];
    out.x[i] = e1.x() * p.x() + e1.y() * p.y() + e1.z() * p.z();
    out.y[i] = e2.x() * p.x() + e2.y() * p.y() + e2.z() * p.z();
    out.h[i] = d.x() * p.x() + d.y() * p.y() + d.z() * p.z();
  }
  auto bounds = [](const std::vector<double>& c, double& lo, double& hi) {
    lo = hi = c.empty() ? 0 : c.front();
    for (const double x : c) {
      lo = std::min(lo, x);
      hi = std::max(hi, x);
    }
  };
  bounds(out.x, out.x_min, out.x_max);
  bounds(out.y, out.y_min, out.y_max);
  bounds(out.h, out.h_min, out.h_max);
}

TrappedVolume TrappedVolumeRaster::measure(const Solid& solid, const Projection& p) {
  const double across = (p.x_max - p.x_min) * (p.y_max - p.y_min);
  const double box = across * (p.h_max - p.h_min);
  TrappedVolume out;
  if (!(box > 0)) return out;
  for (int cells = kCells;; cells *= 2) {
    scan(solid, p, cells);
    const double cell = across / (double(cells) * double(cells));
    const double worst =
        cell * std::max(std::abs(hidden_up_.disagreement()), std::abs(hidden_down_.disagreement()));
    if (worst > kRasterTolerance * box && cells < kMostCells) continue;
    out.up_mm3 = std::max(0.0, prisms_up_ - cell * hidden_up_.total() - solid.volume_mm3);
    out.down_mm3 = std::max(0.0, prisms_down_ - cell * hidden_down_.total() - solid.volume_mm3);
    return out;
  }
}

void TrappedVolumeRaster::scan(const Solid& solid, const Projection& p, int cells) {
  const auto size = static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells);
  tops_.assign(size, 0.0F);
  bottoms_.assign(size, 0.0F);
  hidden_up_ = hidden_down_ = {};
  prisms_up_ = prisms_down_ = 0;
  // Raster coordinates: the centre of cell (i, j) is at x = i, y = j.
  const double sx = cells / (p.x_max - p.x_min);
  const double sy = cells / (p.y_max - p.y_min);
  for (const auto& t : solid.triangles) {
    double x[3];
    double y[3];
    double h[3];
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = p.x[t[k]];
      y[k] = p.y[t[k]];
      h[k] = p.h[t[k]];
    }
    const double twice = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    if (twice == 0) continue;
    const bool up = twice > 0;
    for (double& z : h) z = up ? z - p.h_min : p.h_max - z;
    (up ? prisms_up_ : prisms_down_) += std::abs(twice) * (h[0] + h[1] + h[2]) / 6;
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = (x[k] - p.x_min) * sx - 0.5;
      y[k] = (y[k] - p.y_min) * sy - 0.5;
    }
    scan_triangle(x, y, h, (up ? tops_ : bottoms_).data(), up ? hidden_up_ : hidden_down_, cells);
  }
}

void TrappedVolumeRaster::scan_triangle(const double x[3], const double y[3], const double h[3],
                                        float* buffer, Hidden& hidden, int cells) {
  int low = 0;
  int mid = 1;
  int top = 2;
  if (y[mid] < y[low]) std::swap(low, mid);
  if (y[top] < y[mid]) std::swap(mid, top);
  if (y[mid] < y[low]) std::swap(low, mid);
  // Half open, [bottom, top) and [left, right): facets that share an edge share no cell. An edge's x is
  // computed from its lower end, the same way for both.
  const int first = std::max(0, ceil_int(y[low]));
  const int last = std::min(cells, ceil_int(y[top]));
  if (first >= last) return;
  const double det = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
  const double gx = ((h[1] - h[0]) * (y[2] - y[0]) - (h[2] - h[0]) * (y[1] - y[0])) / det;
  const double gy = ((h[2] - h[0]) * (x[1] - x[0]) - (h[1] - h[0]) * (x[2] - x[0])) / det;
  const double h_low = std::min({h[0], h[1], h[2]});
  const double h_high = std::max({h[0], h[1], h[2]});
  const Edge whole(x, y, low, top);
  const Edge lower(x, y, low, mid);
  const Edge upper(x, y, mid, top);
  for (int j = first; j < last; ++j) {
    const double row = j;
    const double xa = whole.at(row);
    const double xb = row < y[mid] ? lower.at(row) : upper.at(row);
    const int from = std::max(0, ceil_int(std::min(xa, xb)));
    const int to = std::min(cells, ceil_int(std::max(xa, xb)));
    if (from >= to) continue;
    const double z0 = h[0] + gy * (row - y[0]);
    const double za = std::clamp(z0 + gx * (from - x[0]), h_low, h_high);
    const double zb = std::clamp(z0 + gx * (to - 1 - x[0]), h_low, h_high);
    float* cell = buffer + static_cast<std::ptrdiff_t>(j) * cells + from;
    (j % 2 == 0 ? hidden.even : hidden.odd) += deposit(cell, to - from, za, zb);
  }
}

}  // namespace voidpath::orient

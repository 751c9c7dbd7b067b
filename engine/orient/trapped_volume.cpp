#include "engine/orient/trapped_volume.h"

#include <algorithm>
#include <cmath>

namespace voidpath::orient {

namespace {

/// Turn of the raster against the part's main axes across, rad, in coordinates scaled to a square: enough
/// that an edge along an axis crosses dozens of rows, little enough that few cells lie outside.
constexpr double kRasterTurn = 0.1618;
/// Cells across the part, each way: to begin with, about as many in all as there are facets, so that neither
/// facets nor cells are looked at in vain.
constexpr int kFewestCells = 64;
constexpr int kMostCellsAtFirst = 256;
constexpr int kMostCells = 2048;
/// What V may be off by: this share of it, or that of the box around the part, whichever is more.
constexpr double kShareOfVolume = 0.01;
constexpr double kShareOfBox = 0.005;
/// The raster's standard error, reckoned from how much neighbouring rows differ, may be this share of that.
constexpr double kStandardError = 0.4;

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
  const Vec3 su = solid.spread * u;
  const double turn = 0.5 * std::atan2(2 * v.dot(su), u.dot(su) - v.dot(solid.spread * v));
  const Vec3 e1 = std::cos(turn) * u + std::sin(turn) * v;
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
  const double box = std::min(across * (p.h_max - p.h_min), solid.box_mm3);
  TrappedVolume out;
  if (!(box > 0)) return out;
  int cells = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(solid.triangles.size()))),
                         kFewestCells, kMostCellsAtFirst);
  for (;;) {
    place(p, cells);
    scan(solid, p, cells);
    const double error_up = error_of(up_, solid.volume_mm3, box, out.up_mm3);
    const double error_down = error_of(down_, solid.volume_mm3, box, out.down_mm3);
    const double excess = std::max(error_up, error_down) / kStandardError;
    if (excess <= 1 || cells >= kMostCells) return out;
    // Border cells' errors are of the size of a cell and as many as cells along the border: their sum falls
    // with the power 1.5 of the number across. A tenth more, so that once more will mostly do.
    const double grow = std::clamp(1.1 * std::pow(excess, 2.0 / 3.0), 1.2, 4.0);
    cells = std::min(kMostCells, static_cast<int>(std::ceil(cells * grow)));
  }
}

/// V, and its standard error as a share of what it may be off by.
double TrappedVolumeRaster::error_of(const Side& side, double solid_mm3, double box_mm3,
                                     double& v_mm3) const {
  double hidden = 0;
  double differences = 0;
  for (std::size_t j = 0; j < side.hidden.size(); ++j) {
    const double next = j + 1 < side.hidden.size() ? side.hidden[j + 1] : 0;
    hidden += side.hidden[j];
    differences += (side.hidden[j] - next) * (side.hidden[j] - next);
  }
  v_mm3 = std::max(0.0, cell_mm2_ * (side.prisms - hidden) - solid_mm3);
  const double allowed = std::max(kShareOfVolume * v_mm3, kShareOfBox * box_mm3);
  // Rows with errors of variance e² each differ by 2 e² in the square, and add up to that many e².
  return cell_mm2_ * std::sqrt(differences / 2) / allowed;
}

/// Raster coordinates of the vertices: the part's rectangle scaled to a square, turned, and scaled so that
/// the centre of cell (i, j) is at x = i, y = j.
void TrappedVolumeRaster::place(const Projection& p, int cells) {
  const double c = std::cos(kRasterTurn);
  const double s = std::sin(kRasterTurn);
  const double width = p.x_max - p.x_min;
  const double depth = p.y_max - p.y_min;
  const double scale = cells / (c + s);  // cells to a side of the square
  const double x_mid = 0.5 * (p.x_min + p.x_max);
  const double y_mid = 0.5 * (p.y_min + p.y_max);
  const double middle = 0.5 * cells - 0.5;
  cell_mm2_ = width * depth / (scale * scale);
  corners_.resize(p.x.size());
  for (std::size_t v = 0; v < corners_.size(); ++v) {
    const double a = (p.x[v] - x_mid) / width * scale;
    const double b = (p.y[v] - y_mid) / depth * scale;
    corners_[v] = {c * a - s * b + middle, s * a + c * b + middle, p.h[v]};
  }
}

void TrappedVolumeRaster::scan(const Solid& solid, const Projection& p, int cells) {
  const auto size = static_cast<std::size_t>(cells) * static_cast<std::size_t>(cells);
  for (Side* side : {&up_, &down_}) {
    side->surface.assign(size, 0.0F);
    side->hidden.assign(static_cast<std::size_t>(cells), 0.0);
    side->prisms = 0;
  }
  for (const auto& t : solid.triangles) {
    const Corner& a = corners_[t[0]];
    const Corner& b = corners_[t[1]];
    const Corner& c = corners_[t[2]];
    const double twice = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (twice == 0) continue;
    const bool is_up = twice > 0;
    Side& side = is_up ? up_ : down_;
    const double h[3] = {is_up ? a.h - p.h_min : p.h_max - a.h, is_up ? b.h - p.h_min : p.h_max - b.h,
                         is_up ? c.h - p.h_min : p.h_max - c.h};
    side.prisms += std::abs(twice) * (h[0] + h[1] + h[2]) / 6;
    const double x[3] = {a.x, b.x, c.x};
    const double y[3] = {a.y, b.y, c.y};
    scan_triangle(x, y, h, twice, side, cells);
  }
}

void TrappedVolumeRaster::scan_triangle(const double x[3], const double y[3], const double h[3], double det,
                                        Side& side, int cells) {
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
    float* cell = side.surface.data() + static_cast<std::ptrdiff_t>(j) * cells + from;
    side.hidden[static_cast<std::size_t>(j)] += deposit(cell, to - from, za, zb);
  }
}

}  // namespace voidpath::orient

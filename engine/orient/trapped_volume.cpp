#include "engine/orient/trapped_volume.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace voidpath::orient {

namespace {

/// Turn of the raster against the part's main axes across, rad, in coordinates scaled to a square: enough
/// that an edge along an axis crosses several rows, little enough that few cells lie outside.
constexpr double kRasterTurn = 0.1618;
/// Rows across the part. Along a row cells come four at a time, while every further row costs each facet a
/// strip: so cells are narrower than rows.
constexpr int kFewestRows = 48;
constexpr int kMostRowsAtFirst = 256;
constexpr int kMostRows = 1024;
constexpr int kCellsPerRow = 4;
/// What V may be off by: this share of it, or that of the box around the part, whichever is more.
constexpr double kShareOfVolume = 0.01;
constexpr double kShareOfBox = 0.005;
/// The raster's standard error, reckoned from how much neighbouring rows differ, may be this share of that.
constexpr double kStandardError = 0.4;

/// How many rows will do where `rows` of them missed the bound by the factor `excess`. Errors fall at least
/// with the power 1.5 of the number of rows. A tenth more, so that once more will mostly do.
int rows_for(int rows, double excess) {
  const double grow = std::clamp(1.1 * std::pow(excess, 2.0 / 3.0), 1.0, 4.0);
  return std::min(kMostRows, static_cast<int>(std::ceil(rows * grow)));
}

/// Four at once, in whatever registers the machine has; loaded and stored at any address.
typedef float Lanes __attribute__((vector_size(16), aligned(4), may_alias));
typedef std::int32_t Ints __attribute__((vector_size(16)));
constexpr Lanes kSteps{0, 1, 2, 3};

Lanes lower_of(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes higher_of(Lanes a, Lanes b) { return a > b ? a : b; }

int ceil_int(float v) {
  const int i = static_cast<int>(v);
  return i + (static_cast<float>(i) < v ? 1 : 0);
}
Ints ceil_ints(Lanes v) {
  const Ints i = __builtin_convertvector(v, Ints);
  return i - (__builtin_convertvector(i, Lanes) < v);  // true is -1
}

/// The x of an edge by row, reckoned from its lower end.
struct Edge {
  Edge(float xa, float ya, float xb, float yb)
      : x0(xa), y0(ya), slope(yb > ya ? (xb - xa) / (yb - ya) : 0.0F) {}
  Lanes at(Lanes row) const { return x0 + (row - y0) * slope; }
  float x0, y0, slope;
};

/// Lays a strip of surface that rises by `step` a cell over `count` cells: each keeps the higher, and the
/// lower of the two is hidden. Adds the hidden heights to `hidden`, wherever of its four.
void deposit(float* cell, int count, float z, float step, Lanes& hidden) {
  Lanes level = z + kSteps * step;
  const float stride = 4 * step;
  Lanes sums = {};
  for (; count > 4; count -= 4, cell += 4) {
    Lanes& cells = *reinterpret_cast<Lanes*>(cell);
    const Lanes old = cells;
    sums += lower_of(old, level);
    cells = higher_of(old, level);
    level += stride;
  }
  // Nothing is lower than nil: what lies beyond the strip stays as it is.
  level = Ints{0, 1, 2, 3} < count ? level : Lanes{};
  Lanes& cells = *reinterpret_cast<Lanes*>(cell);
  const Lanes old = cells;
  sums += lower_of(old, level);
  cells = higher_of(old, level);
  hidden += sums;
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

TrappedVolumeRaster::TrappedVolumeRaster(const Solid& solid) : solid_(solid) {
  // A few lines tell how many rows this part mostly takes, so that few lines are looked at twice.
  const Vec3 lines[] = {
      {0.36, 0.48, 0.8}, {-0.8, 0.36, 0.48}, {0.48, -0.8, 0.36}, {-0.1, 0.2, 1}, {1, 0.4, -0.1}};
  std::vector<int> rows;
  Projection p;
  for (const Vec3& d : lines) {
    project(solid_, d.normalized(), p);
    TrappedVolume ignored;
    rows.push_back(rows_for(kFewestRows, look(p, kFewestRows, ignored)));
  }
  std::sort(rows.begin(), rows.end());
  first_rows_ = std::min(rows[3], kMostRowsAtFirst);
}

TrappedVolume TrappedVolumeRaster::measure(const Projection& p) {
  TrappedVolume out;
  for (int rows = first_rows_;;) {
    const double excess = look(p, rows, out);
    if (excess <= 1 || rows >= kMostRows) return out;
    rows = std::max(rows + rows / 5, rows_for(rows, excess));
  }
}

/// Fills `out`; returns the standard error as a share of what it may be.
double TrappedVolumeRaster::look(const Projection& p, int rows, TrappedVolume& out) {
  const double across = (p.x_max - p.x_min) * (p.y_max - p.y_min);
  const double box = std::min(across * (p.h_max - p.h_min), solid_.box_mm3);
  out = {};
  if (!(box > 0)) return 0;
  place(p, rows);
  scan(p.h_max - p.h_min, rows);
  const double error_up = error_of(up_, box, out.up_mm3);
  const double error_down = error_of(down_, box, out.down_mm3);
  return std::max(error_up, error_down) / kStandardError;
}

/// V, and its standard error as a share of what it may be off by.
double TrappedVolumeRaster::error_of(const Side& side, double box_mm3, double& v_mm3) {
  rows_.assign(3, 0.0);
  double hidden = 0;
  for (std::size_t j = 0; j < side.hidden.size(); j += 4) {
    double row = 0;
    for (std::size_t k = 0; k < 4; ++k) row += static_cast<double>(side.hidden[j + k]);
    rows_.push_back(row);
    hidden += row;
  }
  rows_.insert(rows_.end(), 3, 0.0);
  v_mm3 = std::max(0.0, cell_mm2_ * (side.prisms - hidden) - solid_.volume_mm3);
  // Third differences pass over what changes evenly from row to row, which sums of rows get right. Errors of
  // variance e² in each row give them a variance of (1 + 9 + 9 + 1) e².
  double squares = 0;
  for (std::size_t j = 3; j < rows_.size(); ++j) {
    const double third = rows_[j] - rows_[j - 3] + 3 * (rows_[j - 2] - rows_[j - 1]);
    squares += third * third;
  }
  const double allowed = std::max(kShareOfVolume * v_mm3, kShareOfBox * box_mm3);
  return cell_mm2_ * std::sqrt(squares / 20) / allowed;
}

/// Raster coordinates of the vertices: the part's rectangle scaled to a square, turned, and scaled so that
/// the centre of cell i of row j is at x = i, y = j.
void TrappedVolumeRaster::place(const Projection& p, int rows) {
  cells_ = rows * kCellsPerRow;
  const double c = std::cos(kRasterTurn);
  const double s = std::sin(kRasterTurn);
  const double width = p.x_max - p.x_min;
  const double depth = p.y_max - p.y_min;
  const double cells_to_side = cells_ / (c + s);
  const double rows_to_side = rows / (c + s);
  const double x_mid = 0.5 * (p.x_min + p.x_max);
  const double y_mid = 0.5 * (p.y_min + p.y_max);
  cell_mm2_ = width * depth / (cells_to_side * rows_to_side);
  corners_.resize(p.x.size());
  const double xx = c / width * cells_to_side;
  const double xy = -s / depth * cells_to_side;
  const double yx = s / width * rows_to_side;
  const double yy = c / depth * rows_to_side;
  for (std::size_t v = 0; v < corners_.size(); ++v) {
    const double a = p.x[v] - x_mid;
    const double b = p.y[v] - y_mid;
    corners_[v] = {xx * a + xy * b + (0.5 * cells_ - 0.5), yx * a + yy * b + (0.5 * rows - 0.5),
                   p.h[v] - p.h_min};
  }
}

void TrappedVolumeRaster::scan(double tall, int rows) {
  const auto row_count = static_cast<std::size_t>(rows);
  for (Side* side : {&up_, &down_}) {
    side->surface.assign(row_count * static_cast<std::size_t>(cells_) + 4, 0.0F);
    side->hidden.assign(4 * row_count, 0.0F);
  }
  double up = 0;
  double down = 0;
  for (const auto& t : solid_.triangles) {
    const Corner& a = corners_[t[0]];
    const Corner& b = corners_[t[1]];
    const Corner& c = corners_[t[2]];
    const double twice = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    const double heights = a.h + b.h + c.h;
    const bool is_up = twice > 0;
    if (is_up) {
      up += twice * heights;
    } else {
      down -= twice * (3 * tall - heights);
    }
    const float y[3] = {static_cast<float>(a.y), static_cast<float>(b.y), static_cast<float>(c.y)};
    const int first = ceil_int(std::min(y[0], std::min(y[1], y[2])));
    const int last = ceil_int(std::max(y[0], std::max(y[1], y[2])));
    if (first >= last || twice == 0) continue;  // most facets of a fine mesh lie between two rows
    const float x[3] = {static_cast<float>(a.x), static_cast<float>(b.x), static_cast<float>(c.x)};
    const float h[3] = {static_cast<float>(is_up ? a.h : tall - a.h),
                        static_cast<float>(is_up ? b.h : tall - b.h),
                        static_cast<float>(is_up ? c.h : tall - c.h)};
    scan_triangle(x, y, h, std::max(0, first), std::min(rows, last), is_up ? up_ : down_);
  }
  up_.prisms = up / 6;
  down_.prisms = down / 6;
}

/// Half open, [first, last) and [from, to): facets that share an edge share no cell. An edge's x is computed
/// from its lower end, the same way for both.
void TrappedVolumeRaster::scan_triangle(const float x[3], const float y[3], const float h[3], int first,
                                        int last, Side& side) {
  // Differences of rounded corners, whose products are exact: a sliver's slopes are those of its corners.
  const double x1 = x[1] - x[0];
  const double x2 = x[2] - x[0];
  const double y1 = y[1] - y[0];
  const double y2 = y[2] - y[0];
  const double det = x1 * y2 - x2 * y1;
  if (det == 0) return;
  const double h1 = h[1] - h[0];
  const double h2 = h[2] - h[0];
  const auto gx = static_cast<float>((h1 * y2 - h2 * y1) / det);
  const auto gy = static_cast<float>((h2 * x1 - h1 * x2) / det);
  std::size_t low = 0;
  std::size_t mid = 1;
  std::size_t top = 2;
  if (y[mid] < y[low]) std::swap(low, mid);
  if (y[top] < y[mid]) std::swap(mid, top);
  if (y[mid] < y[low]) std::swap(low, mid);
  const Lanes h_low = Lanes{} + std::min(h[0], std::min(h[1], h[2]));
  const Lanes h_high = Lanes{} + std::max(h[0], std::max(h[1], h[2]));
  const Edge whole(x[low], y[low], x[top], y[top]);
  const Edge lower(x[low], y[low], x[mid], y[mid]);
  const Edge upper(x[mid], y[mid], x[top], y[top]);
  const Lanes none = {};
  const Lanes all = Lanes{} + static_cast<float>(cells_);
  for (int j = first; j < last; j += 4) {
    const Lanes row = static_cast<float>(j) + kSteps;
    const Lanes xa = whole.at(row);
    const Lanes xb = row < y[mid] ? lower.at(row) : upper.at(row);
    const Ints from = ceil_ints(higher_of(lower_of(xa, xb), none));
    const Ints to = ceil_ints(lower_of(higher_of(xa, xb), all));
    Lanes z = h[0] + gy * (row - y[0]) + gx * (__builtin_convertvector(from, Lanes) - x[0]);
    z = lower_of(higher_of(z, h_low), h_high);
    const int end = std::min(4, last - j);
    for (int k = 0; k < end; ++k) {
      const int count = to[k] - from[k];
      if (count <= 0) continue;
      const auto r = static_cast<std::ptrdiff_t>(j + k);
      deposit(side.surface.data() + r * cells_ + from[k], count, z[k], gx,
              *reinterpret_cast<Lanes*>(side.hidden.data() + 4 * r));
    }
  }
}

}  // namespace voidpath::orient

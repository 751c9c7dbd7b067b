#include "engine/orient/trapped_volume.h"

#include "engine/orient/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace voidpath::orient {

namespace {

/// Rows across the part. Along a row cells come four at a time, while every further row costs each facet a
/// strip: so cells are narrower than rows.
constexpr int kFewestRows = 56;
constexpr int kMostRowsAtFirst = 256;
constexpr int kMostRows = 1024;
constexpr int kCellsPerRow = 4;
/// What V may be off by: this share of it, or that of the box around the part, whichever is more.
constexpr double kShareOfVolume = 0.01;
constexpr double kShareOfBox = 0.005;
/// The raster's standard error, reckoned from how much neighbouring rows differ, may be this share of that.
constexpr double kStandardError = 0.25;

/// How many rows will do where `rows` of them missed the bound by the factor `excess`. Errors fall at least
/// with the power 1.5 of the number of rows. A tenth more, so that once more will mostly do.
int rows_for(int rows, double excess) {
  const double grow = std::clamp(1.1 * std::pow(excess, 2.0 / 3.0), 1.0, 4.0);
  return std::min(kMostRows, static_cast<int>(std::ceil(rows * grow)));
}

constexpr Lanes kSteps{0, 1, 2, 3};

constexpr std::size_t kAfter[3] = {1, 2, 0};

int ceil_int(float v) {
  const int i = static_cast<int>(v);
  return i + (static_cast<float>(i) < v ? 1 : 0);
}
Ints ceil_ints(Lanes v) {
  const Ints i = __builtin_convertvector(v, Ints);
  return i - (__builtin_convertvector(i, Lanes) < v);  // true is -1
}

/// Whatever 16 bytes, four floats of which are of use or fewer.
template <class T>
Lanes as_lanes(const T& v) {
  static_assert(sizeof(T) == sizeof(Lanes));
  return *reinterpret_cast<const Lanes*>(&v);
}

Lanes lanes_at(const std::vector<float>& v, int i) { return *reinterpret_cast<const Lanes*>(v.data() + i); }

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

/// The x of an edge by row, reckoned from its lower end.
struct TrappedVolumeRaster::Edge {
  Edge(const Corner& low, const Corner& high)
      : x0(low.x), y0(low.y), dx(high.x - low.x), per_y(high.y > low.y ? 1 / (high.y - low.y) : 0.0F) {}
  Lanes at(Lanes row) const { return x0 + (row - y0) * per_y * dx; }
  float x0, y0, dx, per_y;
};

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
  out.d = d;
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

TrappedVolumeRaster::TrappedVolumeRaster(const Solid& solid) : solid_(solid), slant_(solid) {
  // A few lines tell how many rows this part mostly takes, so that few lines are looked at twice.
  const Vec3 lines[] = {
      {0.36, 0.48, 0.8}, {-0.8, 0.36, 0.48}, {0.48, -0.8, 0.36}, {-0.1, 0.2, 1}, {1, 0.4, -0.1}};
  std::vector<int> rows;
  Projection p;
  for (const Vec3& d : lines) {
    project(solid_, d.normalized(), p);
    sum_prisms(p);
    TrappedVolume ignored;
    rows.push_back(rows_for(kFewestRows, look(p, kFewestRows, ignored)));
  }
  std::sort(rows.begin(), rows.end());
  first_rows_ = std::min(rows[3], kMostRowsAtFirst);
}

TrappedVolume TrappedVolumeRaster::measure(const Projection& p) {
  TrappedVolume out;
  sum_prisms(p);
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
  scan(static_cast<float>(p.h_max - p.h_min), rows);
  const double error_up = error_of(up_, box, out.up_mm3);
  const double error_down = error_of(down_, box, out.down_mm3);
  return std::max(error_up, error_down) / kStandardError;
}

/// Sums of heights over the cells of each row, with empty rows around.
void TrappedVolumeRaster::sum_rows(const Side& side) {
  sums_.assign(RasterRows::kEmptyAround, {});
  for (std::size_t j = 0; j < rows_.weight.size(); ++j) {
    const float* cells = side.surface.data() + j * static_cast<std::size_t>(cells_);
    Lanes tops = {};
    for (int i = 0; i < cells_; i += 4) tops += *reinterpret_cast<const Lanes*>(cells + i);
    RowSums sums;
    for (std::size_t k = 0; k < 4; ++k) {
      sums.hidden += static_cast<double>(side.hidden[4 * j + k]);
      sums.all += static_cast<double>(tops[k]);
    }
    sums.all += sums.hidden;
    sums_.push_back(sums);
  }
  sums_.insert(sums_.end(), RasterRows::kEmptyAround, {});
}

/// V, and its standard error as a share of what it may be off by.
double TrappedVolumeRaster::error_of(const Side& side, double box_mm3, double& v_mm3) {
  sum_rows(side);
  double hidden = 0;
  double all = 0;
  for (std::size_t j = 0; j < rows_.weight.size(); ++j) {
    const RowSums& row = sums_[j + RasterRows::kEmptyAround];
    hidden += rows_.weight[j] * row.hidden;
    all += rows_.weight[j] * row.all;
  }
  // Independent errors of rows have these squares and products, summed over the rows.
  double hh = 0;
  double ha = 0;
  double aa = 0;
  for (std::size_t j = 0; j < rows_.thirds.size(); ++j) {
    double h = 0;
    double a = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      h += rows_.thirds[j][k] * sums_[j + k].hidden;
      a += rows_.thirds[j][k] * sums_[j + k].all;
    }
    hh += h * h;
    ha += h * a;
    aa += a * a;
  }
  const double share = aa > 0 ? std::clamp(ha / aa, 0.0, 1.0) : 0.0;
  const double above = side.prisms_mm3 - cell_mm2_ * hidden - share * (side.prisms_mm3 - cell_mm2_ * all);
  v_mm3 = std::max(0.0, above - solid_.volume_mm3);
  const double variance = std::max(0.0, hh - 2 * share * ha + share * share * aa);
  const double allowed = std::max(kShareOfVolume * v_mm3, kShareOfBox * box_mm3);
  return cell_mm2_ * std::sqrt(variance) / allowed;
}

/// A prism's volume is the facet's area as seen along d times the height of its centroid.
void TrappedVolumeRaster::sum_prisms(const Projection& p) {
  using Pair = Columns::Register;
  Pair up = {};
  Pair down = {};
  for (std::size_t i = 0; i < solid_.areas.padded(); i += Columns::kStep) {
    const Pair area = solid_.areas.dot(i, p.d);
    const Pair middle = solid_.middles.dot(i, p.d);
    const Pair none = {};
    up += (area > none ? area : none) * (middle - p.h_min);
    down += (area < none ? area : none) * (middle - p.h_max);
  }
  up_.prisms_mm3 = up[0] + up[1];
  down_.prisms_mm3 = down[0] + down[1];
}

/// Raster coordinates of the vertices: the part's rectangle scaled to a square, slanted, and scaled so that
/// cells are one wide and rows one apart on average.
void TrappedVolumeRaster::place(const Projection& p, int rows) {
  if (rows_.weight.size() != static_cast<std::size_t>(rows)) rows_.lay(rows);
  cells_ = rows * kCellsPerRow;
  const auto slope = static_cast<double>(slant_.best(p));
  const double width = p.x_max - p.x_min;
  const double depth = p.y_max - p.y_min;
  const double rows_to_side = rows / (1 + std::abs(slope));
  const double x_mid = 0.5 * (p.x_min + p.x_max);
  const double y_mid = 0.5 * (p.y_min + p.y_max);
  cell_mm2_ = width * depth / (cells_ * rows_to_side);
  corners_.resize(p.x.size());
  next_rows_.resize(p.x.size());
  const double xx = cells_ / width;
  const double yx = slope / width * rows_to_side;
  const double yy = rows_to_side / depth;
  for (std::size_t v = 0; v < corners_.size(); ++v) {
    const double a = p.x[v] - x_mid;
    const double b = p.y[v] - y_mid;
    const auto y = static_cast<float>(yx * a + yy * b + 0.5 * rows);
    int next = std::clamp(static_cast<int>(y), 0, rows);
    next += rows_.y[static_cast<std::size_t>(next)] < y ? 1 : 0;
    corners_[v] = {static_cast<float>(xx * a + 0.5 * cells_), y, static_cast<float>(p.h[v] - p.h_min),
                   static_cast<float>(next)};
    next_rows_[v] = static_cast<std::int16_t>(next);
  }
}

void TrappedVolumeRaster::scan(float tall, int rows) {
  const auto row_count = static_cast<std::size_t>(rows);
  for (Side* side : {&up_, &down_}) {
    side->surface.assign(row_count * static_cast<std::size_t>(cells_) + 4, 0.0F);
    side->hidden.assign(4 * row_count, 0.0F);
  }
  for (const auto& t : solid_.triangles) {
    const std::int16_t a = next_rows_[t[0]];
    const std::int16_t b = next_rows_[t[1]];
    const std::int16_t c = next_rows_[t[2]];
    const int first = std::min(a, std::min(b, c));
    const int last = std::max(a, std::max(b, c));
    if (first == last) continue;  // most facets of a fine mesh lie between two rows
    if (last == first + 1) {
      scan_row(t, tall);
    } else {
      scan_rows(corners_[t[0]], corners_[t[1]], corners_[t[2]], tall, first, last);
    }
  }
}

/// A facet that one row crosses, as most of a fine mesh that are crossed at all. Which of its corners lie
/// where is as good as random, so nothing branches on it.
void TrappedVolumeRaster::scan_row(const mesh::Triangle& t, float tall) {
  const std::int16_t a = next_rows_[t[0]];
  const std::size_t alone = (next_rows_[t[2]] == a ? 1U : 0U) + (next_rows_[t[1]] == a ? 2U : 0U);
  // Corner k alone lies on its side of the row; n comes after it, m before.
  const Corner& k = corners_[t[alone]];
  const Corner& n = corners_[t[kAfter[alone]]];
  const Corner& m = corners_[t[kAfter[kAfter[alone]]]];
  const bool k_low = k.next_row < n.next_row;
  const auto row = static_cast<std::size_t>(std::min(k.next_row, n.next_row));
  const float y = rows_.y[row];
  const float shift = rows_.shift[row];
  const Ints swap = Ints{} - (k_low ? 1 : 0);
  auto cross = [&](const Corner& other) {
    const Lanes from_k = as_lanes(k);
    const Lanes from_other = as_lanes(other);
    const Lanes low = swap ? from_k : from_other;
    const Lanes high = swap ? from_other : from_k;
    return low + (y - low[1]) * (1 / (high[1] - low[1])) * (high - low);  // as Edge has it
  };
  const Lanes at_n = cross(n);
  const Lanes at_m = cross(m);
  const int from = std::max(0, ceil_int(std::min(at_n[0], at_m[0]) - shift));
  const int to = std::min(cells_, ceil_int(std::max(at_n[0], at_m[0]) - shift));
  if (from >= to) return;
  // Counter-clockwise facets, which look up, have n to the right of m over a corner below, else to the left.
  const bool is_up = (at_n[0] > at_m[0]) == k_low;
  const float step = (at_n[2] - at_m[2]) / (at_n[0] - at_m[0]);
  const float h_low = std::min({k.h, n.h, m.h});
  const float h_high = std::max({k.h, n.h, m.h});
  const float z = std::clamp(at_m[2] + step * (static_cast<float>(from) + shift - at_m[0]), h_low, h_high);
  Side& side = is_up ? up_ : down_;
  deposit(side.surface.data() + row * static_cast<std::size_t>(cells_) + from, to - from,
          is_up ? z : tall - z, is_up ? step : -step,
          *reinterpret_cast<Lanes*>(side.hidden.data() + 4 * row));
}

/// Half open, [first, last) and [from, to): facets that share an edge share no cell. An edge's x is computed
/// from its lower end, the same way for both.
void TrappedVolumeRaster::scan_rows(const Corner& a, const Corner& b, const Corner& c, float tall, int first,
                                    int last) {
  // Differences of rounded corners, whose products are exact: a sliver's slopes are those of its corners.
  const double x1 = b.x - a.x;
  const double x2 = c.x - a.x;
  const double y1 = b.y - a.y;
  const double y2 = c.y - a.y;
  const double det = x1 * y2 - x2 * y1;
  if (det == 0) return;
  const bool is_up = det > 0;
  Side& side = is_up ? up_ : down_;
  const double h1 = is_up ? b.h - a.h : a.h - b.h;
  const double h2 = is_up ? c.h - a.h : a.h - c.h;
  const auto gx = static_cast<float>((h1 * y2 - h2 * y1) / det);
  const auto gy = static_cast<float>((h2 * x1 - h1 * x2) / det);
  const Corner* low = &a;
  const Corner* mid = &b;
  const Corner* top = &c;
  if (mid->y < low->y) std::swap(low, mid);
  if (top->y < mid->y) std::swap(mid, top);
  if (mid->y < low->y) std::swap(low, mid);
  const float least = std::min({a.h, b.h, c.h});
  const float most = std::max({a.h, b.h, c.h});
  const Lanes h_low = Lanes{} + (is_up ? least : tall - most);
  const Lanes h_high = Lanes{} + (is_up ? most : tall - least);
  const float h0 = is_up ? a.h : tall - a.h;
  const Edge whole(*low, *top);
  const Edge lower(*low, *mid);
  const Edge upper(*mid, *top);
  const Lanes none = {};
  const Lanes all = Lanes{} + static_cast<float>(cells_);
  for (int j = first; j < last; j += 4) {
    const Lanes row = lanes_at(rows_.y, j);
    const Lanes shift = lanes_at(rows_.shift, j);
    const Lanes xa = whole.at(row);
    const Lanes xb = row < mid->y ? lower.at(row) : upper.at(row);
    const Ints from = ceil_ints(higher_of(lower_of(xa, xb) - shift, none));
    const Ints to = ceil_ints(lower_of(higher_of(xa, xb) - shift, all));
    Lanes z = h0 + gy * (row - a.y) + gx * (__builtin_convertvector(from, Lanes) + shift - a.x);
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

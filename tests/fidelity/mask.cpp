#include "tests/fidelity/mask.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::fidelity {

namespace {

constexpr float kFar = 1e12F;

/// Squared distances along a row whose values are those in each column alone (Felzenszwalb and Huttenlocher
/// 2012, Distance Transforms of Sampled Functions, Alg. 1). Pixels.
class RowPass {
 public:
  explicit RowPass(int n) : f_(size(n)), z_(size(n) + 1), v_(size(n)) {}

  void run(float* values, int n) {
    int k = -1;
    for (int q = 0; q < n; ++q) {
      f_[size(q)] = values[q];
      if (values[q] >= kFar) continue;
      double s = -std::numeric_limits<double>::infinity();
      while (k >= 0) {
        const int p = v_[size(k)];
        s = (square(q) + f_[size(q)] - square(p) - f_[size(p)]) / (2.0 * (q - p));
        if (s > z_[size(k)]) break;
        --k;
      }
      if (k < 0) s = -std::numeric_limits<double>::infinity();
      ++k;
      v_[size(k)] = q;
      z_[size(k)] = s;
    }
    if (k < 0) return;
    z_[size(k) + 1] = std::numeric_limits<double>::infinity();
    for (int q = 0, at = 0; q < n; ++q) {
      while (z_[size(at) + 1] < q) ++at;
      const int p = v_[size(at)];
      values[q] = static_cast<float>(square(q - p) + f_[size(p)]);
    }
  }

 private:
  static std::size_t size(int i) { return static_cast<std::size_t>(i); }
  static double square(int v) { return static_cast<double>(v) * v; }
  std::vector<double> f_, z_;
  std::vector<int> v_;
};

/// Distance in whole pixels to the nearest marked pixel of the same column, row after row.
void column_pass(std::vector<float>& d, const Grid& grid) {
  const auto nx = static_cast<std::size_t>(grid.nx);
  for (std::size_t i = nx; i < d.size(); ++i) d[i] = std::min(d[i], d[i - nx] + 1);
  for (std::size_t i = d.size() - nx; i-- > 0;) d[i] = std::min(d[i], d[i + nx] + 1);
  for (float& v : d) v = v >= kFar ? kFar : v * v;
}

/// From the first to the last of columns and rows, as far as the grid has them; without a mask.
Window window(const Grid& grid, int i0, int i1, int j0, int j1) {
  Window out;
  out.i0 = std::max(0, i0);
  out.j0 = std::max(0, j0);
  out.grid = grid;
  out.grid.x0 += out.i0 * grid.size;
  out.grid.y0 += out.j0 * grid.size;
  out.grid.nx = std::min(grid.nx, i1 + 1) - out.i0;
  out.grid.ny = std::min(grid.ny, j1 + 1) - out.j0;
  return out;
}

}  // namespace

std::optional<std::size_t> Grid::pixel(double x, double y) const {
  const int i = static_cast<int>(std::floor((x - x0) / size));
  const int j = static_cast<int>(std::floor((y - y0) / size));
  if (i < 0 || j < 0 || i >= nx || j >= ny) return std::nullopt;
  return at(i, j);
}

void draw(Mask& mask, const Grid& grid, const Bead& bead, double wider) {
  const double r = 0.5 * bead.width + wider;
  const auto pixel = [&](double v, double origin) {
    return static_cast<int>(std::floor((v - origin) / grid.size));
  };
  const int i0 = std::max(0, pixel(std::min(bead.x0, bead.x1) - r, grid.x0));
  const int i1 = std::min(grid.nx - 1, pixel(std::max(bead.x0, bead.x1) + r, grid.x0));
  const int j0 = std::max(0, pixel(std::min(bead.y0, bead.y1) - r, grid.y0));
  const int j1 = std::min(grid.ny - 1, pixel(std::max(bead.y0, bead.y1) + r, grid.y0));
  const double dx = bead.x1 - bead.x0, dy = bead.y1 - bead.y0;
  const double length2 = std::max(dx * dx + dy * dy, 1e-18);
  for (int j = j0; j <= j1; ++j) {
    const double y = grid.y0 + (j + 0.5) * grid.size;
    // Along a row the strand is one stretch: look only near it.
    int from = i0, to = i1;
    if (std::abs(dy) > 1e-9) {
      const double half = r * std::sqrt(length2) / std::abs(dy) + r;
      const double x = bead.x0 + dx * (y - bead.y0) / dy;
      const double low = std::min({x - half, std::max(bead.x0, bead.x1) + r});
      const double high = std::max({x + half, std::min(bead.x0, bead.x1) - r});
      from = std::max(from, pixel(low, grid.x0));
      to = std::min(to, pixel(high, grid.x0));
    }
    for (int i = from; i <= to; ++i) {
      const double x = grid.x0 + (i + 0.5) * grid.size;
      const double t = std::clamp(((x - bead.x0) * dx + (y - bead.y0) * dy) / length2, 0.0, 1.0);
      const double ex = x - bead.x0 - t * dx, ey = y - bead.y0 - t * dy;
      if (ex * ex + ey * ey <= r * r) mask[grid.at(i, j)] = 1;
    }
  }
}

Mask fill(const std::vector<Edge>& edges, const Grid& grid) {
  struct Crossing {
    double x;
    int winding;
  };
  std::vector<std::vector<Crossing>> rows(static_cast<std::size_t>(grid.ny));
  for (const Edge& e : edges) {
    const bool up = e.y1 > e.y0;
    const double low = std::min(e.y0, e.y1), high = std::max(e.y0, e.y1);
    const int j0 = std::max(0, static_cast<int>(std::ceil((low - grid.y0) / grid.size - 0.5)));
    const int j1 = std::min(grid.ny, static_cast<int>(std::ceil((high - grid.y0) / grid.size - 0.5)));
    for (int j = j0; j < j1; ++j) {
      const double y = grid.y0 + (j + 0.5) * grid.size;
      const double x = e.x0 + (e.x1 - e.x0) * (y - e.y0) / (e.y1 - e.y0);
      rows[static_cast<std::size_t>(j)].push_back({x, up ? -1 : 1});
    }
  }
  Mask out(grid.count(), 0);
  for (int j = 0; j < grid.ny; ++j) {
    auto& row = rows[static_cast<std::size_t>(j)];
    std::sort(row.begin(), row.end(), [](const Crossing& a, const Crossing& b) { return a.x < b.x; });
    int winding = 0;
    for (std::size_t k = 0; k + 1 < row.size(); ++k) {
      winding += row[k].winding;
      if (winding <= 0) continue;
      const int i0 = std::max(0, static_cast<int>(std::ceil((row[k].x - grid.x0) / grid.size - 0.5)));
      const int i1 =
          std::min(grid.nx, static_cast<int>(std::ceil((row[k + 1].x - grid.x0) / grid.size - 0.5)));
      for (int i = i0; i < i1; ++i) out[grid.at(i, j)] = 1;
    }
  }
  return out;
}

void add_slivers(Mask& areas, const std::vector<Edge>& edges, const Grid& grid) {
  std::vector<std::size_t> found;
  const auto bare = [&](int i, int j) {
    for (int y = std::max(0, j - 1); y <= std::min(grid.ny - 1, j + 1); ++y)
      for (int x = std::max(0, i - 1); x <= std::min(grid.nx - 1, i + 1); ++x)
        if (areas[grid.at(x, y)] != 0) return false;
    return true;
  };
  for (const Edge& e : edges) {
    const double dx = e.x1 - e.x0, dy = e.y1 - e.y0;
    const int steps = static_cast<int>(std::ceil(2 * std::max(std::abs(dx), std::abs(dy)) / grid.size)) + 1;
    for (int k = 0; k <= steps; ++k) {
      const double t = static_cast<double>(k) / steps;
      const int i = static_cast<int>(std::floor((e.x0 + t * dx - grid.x0) / grid.size));
      const int j = static_cast<int>(std::floor((e.y0 + t * dy - grid.y0) / grid.size));
      if (i < 0 || j < 0 || i >= grid.nx || j >= grid.ny) continue;
      if (bare(i, j)) found.push_back(grid.at(i, j));
    }
  }
  for (const std::size_t p : found) areas[p] = 1;
}

std::vector<float> distance_to(const Mask& mask, const Grid& grid) {
  std::vector<float> d(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) d[i] = mask[i] != 0 ? 0.0F : kFar;
  column_pass(d, grid);
  RowPass pass(grid.nx);
  for (int j = 0; j < grid.ny; ++j) pass.run(&d[grid.at(0, j)], grid.nx);
  const auto size = static_cast<float>(grid.size);
  for (float& v : d) v = std::sqrt(v) * size;
  return d;
}

Mask Window::same(const Mask& whole, const Grid& of) const {
  Mask out(grid.count());
  for (int j = 0; j < grid.ny; ++j) std::copy_n(&whole[of.at(i0, j0 + j)], grid.nx, &out[grid.at(0, j)]);
  return out;
}

std::size_t Window::whole(std::size_t pixel, const Grid& of) const {
  const auto nx = static_cast<std::size_t>(grid.nx);
  return of.at(i0 + static_cast<int>(pixel % nx), j0 + static_cast<int>(pixel / nx));
}

Window cropped(const Mask& mask, const Grid& grid, int margin) {
  int i0 = grid.nx, i1 = -1, j0 = grid.ny, j1 = -1;
  for (int j = 0; j < grid.ny; ++j) {
    const std::uint8_t* row = &mask[grid.at(0, j)];
    const auto* first = std::find(row, row + grid.nx, std::uint8_t{1});
    if (first == row + grid.nx) continue;
    int last = grid.nx - 1;
    while (row[last] == 0) --last;
    i0 = std::min(i0, static_cast<int>(first - row));
    i1 = std::max(i1, last);
    j0 = std::min(j0, j);
    j1 = j;
  }
  if (j1 < 0) return {};
  Window out = window(grid, i0 - margin, i1 + margin, j0 - margin, j1 + margin);
  out.mask = out.same(mask, grid);
  return out;
}

Window around(const std::vector<std::size_t>& pixels, const Grid& grid, int margin) {
  const auto nx = static_cast<std::size_t>(grid.nx);
  int i0 = grid.nx, i1 = -1, j0 = grid.ny, j1 = -1;
  for (const std::size_t p : pixels) {
    const int i = static_cast<int>(p % nx), j = static_cast<int>(p / nx);
    i0 = std::min(i0, i);
    i1 = std::max(i1, i);
    j0 = std::min(j0, j);
    j1 = std::max(j1, j);
  }
  if (pixels.empty()) return {};
  Window out = window(grid, i0 - margin, i1 + margin, j0 - margin, j1 + margin);
  out.mask.assign(out.grid.count(), 0);
  for (const std::size_t p : pixels)
    out.mask[out.grid.at(static_cast<int>(p % nx) - out.i0, static_cast<int>(p / nx) - out.j0)] = 1;
  return out;
}

Mask shrunk_square(const Mask& mask, const Grid& grid, int by) {
  Mask rows(mask.size(), 0), out(mask.size(), 0);
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0, run = 0; i < grid.nx; ++i) {
      run = mask[grid.at(i, j)] != 0 ? run + 1 : 0;
      if (run > 2 * by) rows[grid.at(i - by, j)] = 1;
    }
  std::vector<int> run(static_cast<std::size_t>(grid.nx), 0);
  for (int j = 0; j < grid.ny; ++j)
    for (int i = 0; i < grid.nx; ++i) {
      int& r = run[static_cast<std::size_t>(i)];
      r = rows[grid.at(i, j)] != 0 ? r + 1 : 0;
      if (r > 2 * by) out[grid.at(i, j - by)] = 1;
    }
  return out;
}

std::optional<double> near(const Mask& mask, const Grid& grid, std::size_t pixel, int reach) {
  const auto nx = static_cast<std::size_t>(grid.nx);
  const int x = static_cast<int>(pixel % nx), y = static_cast<int>(pixel / nx);
  int best = reach * reach + 1;
  for (int j = std::max(0, y - reach); j <= std::min(grid.ny - 1, y + reach); ++j)
    for (int i = std::max(0, x - reach); i <= std::min(grid.nx - 1, x + reach); ++i)
      if (mask[grid.at(i, j)] != 0) best = std::min(best, (i - x) * (i - x) + (j - y) * (j - y));
  if (best > reach * reach) return std::nullopt;
  return std::sqrt(static_cast<double>(best)) * grid.size;
}

Nearby::Nearby(const Mask& mask, const Grid& grid)
    : mask_(mask), grid_(grid), nx_(grid.nx / kTile + 1), ny_(grid.ny / kTile + 1) {
  tiles_.resize(static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_), 0);
  // Whole tiles' worth of rows are laid over one another first.
  Mask rows(static_cast<std::size_t>(nx_) * kTile);
  for (int j = 0; j < grid.ny; ++j) {
    const std::uint8_t* row = &mask[grid.at(0, j)];
    if (j % kTile == 0) std::fill(rows.begin(), rows.end(), std::uint8_t{0});
    for (std::size_t i = 0; i < static_cast<std::size_t>(grid.nx); ++i) rows[i] |= row[i];
    if (j % kTile != kTile - 1 && j + 1 < grid.ny) continue;
    for (int t = 0; t < nx_; ++t) {
      const auto from = rows.begin() + static_cast<std::ptrdiff_t>(t) * kTile;
      tiles_[tile(t, j / kTile)] = *std::max_element(from, from + kTile);
    }
  }
}

bool Nearby::within(std::size_t pixel, double reach_mm) {
  if (mask_[pixel] != 0) return true;
  const double reach = reach_mm / grid_.size;
  if (reach <= 2 * kTile) {
    const auto d = near(mask_, grid_, pixel, static_cast<int>(reach));
    return d.has_value() && *d <= reach_mm;
  }
  const auto nx = static_cast<std::size_t>(grid_.nx);
  const int x = static_cast<int>(pixel % nx) / kTile, y = static_cast<int>(pixel / nx) / kTile;
  // A tile that far away lies wholly within reach: its far corner is (rings + 1) tiles off, both ways.
  const int rings = static_cast<int>(reach / std::sqrt(2.0) / kTile) - 1;
  for (int j = std::max(0, y - rings); j <= std::min(ny_ - 1, y + rings); ++j)
    for (int i = std::max(0, x - rings); i <= std::min(nx_ - 1, x + rings); ++i)
      if (tiles_[tile(i, j)] != 0) return true;
  if (far_.empty()) far_ = distance_to(mask_, grid_);
  return static_cast<double>(far_[pixel]) <= reach_mm;
}

Mask grown(const Mask& mask, const Grid& grid, double by) {
  const auto d = distance_to(mask, grid);
  Mask out(mask.size());
  for (std::size_t i = 0; i < d.size(); ++i) out[i] = static_cast<double>(d[i]) <= by ? 1 : 0;
  return out;
}

Mask shrunk(const Mask& mask, const Grid& grid, double by) {
  Mask inverse(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) inverse[i] = mask[i] == 0;
  const auto d = distance_to(inverse, grid);
  for (std::size_t i = 0; i < d.size(); ++i) inverse[i] = static_cast<double>(d[i]) > by ? 1 : 0;
  return inverse;
}

Mask both(const Mask& a, const Mask& b) {
  Mask out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] & b[i];
  return out;
}
Mask without(const Mask& a, const Mask& b) {
  Mask out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] & (b[i] ^ 1u);
  return out;
}
std::size_t count(const Mask& mask) {
  return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), std::uint8_t{1}));
}

}  // namespace voidpath::fidelity

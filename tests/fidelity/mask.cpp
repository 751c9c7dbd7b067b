#include "tests/fidelity/mask.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voidpath::fidelity {

namespace {

/// One pass of the squared distance transform along a line of n values, `step` apart (Felzenszwalb and
/// Huttenlocher 2012, Distance Transforms of Sampled Functions, Alg. 1). Pixels.
class LinePass {
 public:
  explicit LinePass(int n) : f_(size(n)), z_(size(n) + 1), v_(size(n)) {}

  void run(float* values, int n, std::size_t step) {
    for (int q = 0; q < n; ++q) f_[size(q)] = values[size(q) * step];
    int k = -1;
    for (int q = 0; q < n; ++q) {
      if (f_[size(q)] >= kFar) continue;
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
      values[size(q) * step] = static_cast<float>(square(q - p) + f_[size(p)]);
    }
  }

  static constexpr float kFar = 1e12F;

 private:
  static std::size_t size(int i) { return static_cast<std::size_t>(i); }
  static double square(int v) { return static_cast<double>(v) * v; }
  std::vector<double> f_, z_;
  std::vector<int> v_;
};

template <class F>
Mask combined(const Mask& a, const Mask& b, F&& f) {
  Mask out(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) out[i] = f(a[i], b[i]) ? 1 : 0;
  return out;
}

}  // namespace

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

std::vector<float> distance_to(const Mask& mask, const Grid& grid) {
  std::vector<float> d(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) d[i] = mask[i] != 0 ? 0.0F : LinePass::kFar;
  LinePass pass(std::max(grid.nx, grid.ny));
  for (int i = 0; i < grid.nx; ++i) pass.run(&d[grid.at(i, 0)], grid.ny, static_cast<std::size_t>(grid.nx));
  for (int j = 0; j < grid.ny; ++j) pass.run(&d[grid.at(0, j)], grid.nx, 1);
  for (float& v : d) v = static_cast<float>(std::sqrt(static_cast<double>(v)) * grid.size);
  return d;
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
  return combined(a, b, [](auto x, auto y) { return x != 0 && y != 0; });
}
Mask without(const Mask& a, const Mask& b) {
  return combined(a, b, [](auto x, auto y) { return x != 0 && y == 0; });
}
std::size_t count(const Mask& mask) {
  return static_cast<std::size_t>(std::count(mask.begin(), mask.end(), std::uint8_t{1}));
}

}  // namespace voidpath::fidelity

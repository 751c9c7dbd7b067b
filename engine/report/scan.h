#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace voidpath::report {

/// A triangle's corner in raster units, cell (i, j) spanning [i, i + 1) x [j, j + 1), and a value to carry.
struct Corner {
  double x = 0, y = 0, value = 0;
};

/// Calls at(i, j, value) for every cell whose middle the triangle covers. Of triangles that share an edge
/// exactly one gets a middle on it.
template <class At>
void scan(const std::array<Corner, 3>& c, int width, int height, At&& at) {
  const double det = (c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y);
  if (det == 0) return;
  const double dx =
      ((c[1].value - c[0].value) * (c[2].y - c[0].y) - (c[2].value - c[0].value) * (c[1].y - c[0].y)) / det;
  const double dy =
      ((c[2].value - c[0].value) * (c[1].x - c[0].x) - (c[1].value - c[0].value) * (c[2].x - c[0].x)) / det;
  // The plane of a sliver runs wild between its corners' values.
  const auto [least, most] = std::minmax({c[0].value, c[1].value, c[2].value});
  const auto [low, high] = std::minmax({c[0].y, c[1].y, c[2].y});
  const int first = std::max(0, static_cast<int>(std::ceil(low - 0.5)));
  const int last = std::min(height - 1, static_cast<int>(std::ceil(high - 0.5)) - 1);
  for (int j = first; j <= last; ++j) {
    const double y = j + 0.5;
    std::array<double, 2> x{0, 0};
    std::size_t n = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      Corner a = c[k];
      Corner b = c[(k + 1) % 3];
      if (a.y > b.y || (a.y == b.y && a.x > b.x)) std::swap(a, b);  // both neighbours reckon alike
      if (n < 2 && a.y <= y && y < b.y) x[n++] = a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x);
    }
    if (n < 2) continue;
    if (x[0] > x[1]) std::swap(x[0], x[1]);
    const int from = std::max(0, static_cast<int>(std::ceil(x[0] - 0.5)));
    const int to = std::min(width - 1, static_cast<int>(std::ceil(x[1] - 0.5)) - 1);
    for (int i = from; i <= to; ++i)
      at(i, j, std::clamp(c[0].value + dx * (i + 0.5 - c[0].x) + dy * (y - c[0].y), least, most));
  }
}

}  // namespace voidpath::report

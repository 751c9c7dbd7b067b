#pragma once

#include "engine/orient/cross_section.h"

#include <array>
#include <cstddef>
#include <vector>

namespace voidpath::orient {

/// Drops points that lie within the octagon of those furthest along eight directions, and so on no convex
/// hull (Akl and Toussaint 1978): few are left to sort. `at(item)` is the point of an item.
template <class Item, class At>
void drop_inner(std::vector<Item>& items, const At& at) {
  constexpr std::size_t kFew = 16;
  if (items.size() <= kFew) return;
  // Counter-clockwise.
  constexpr double kDirections[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  std::array<Point2, 8> far;
  std::array<double, 8> most;
  far.fill(at(items.front()));
  for (std::size_t k = 0; k < 8; ++k) most[k] = kDirections[k][0] * far[k].x + kDirections[k][1] * far[k].y;
  for (const Item& item : items) {
    const Point2 p = at(item);
    const double along[8] = {p.x, p.x + p.y, p.y, p.y - p.x, -p.x, -p.x - p.y, -p.y, p.x - p.y};
    for (std::size_t k = 0; k < 8; ++k)
      if (along[k] > most[k]) {
        most[k] = along[k];
        far[k] = p;
      }
  }
  // Inside by more than rounding can mistake.
  const double margin = 1e-12 * (most[0] + most[4]) * (most[2] + most[6]);
  std::array<double, 8> a;
  std::array<double, 8> b;
  std::array<double, 8> c;
  for (std::size_t k = 0; k < 8; ++k) {
    const Point2 p = far[k];
    const Point2 q = far[(k + 1) % 8];
    const bool same = p.x == q.x && p.y == q.y;
    a[k] = p.y - q.y;
    b[k] = q.x - p.x;
    c[k] = same ? -2 * margin - 1 : a[k] * p.x + b[k] * p.y + margin;
  }
  std::erase_if(items, [&](const Item& item) {
    const Point2 p = at(item);
    for (std::size_t k = 0; k < 8; ++k)
      if (!(a[k] * p.x + b[k] * p.y > c[k])) return false;
    return true;
  });
}

}  // namespace voidpath::orient

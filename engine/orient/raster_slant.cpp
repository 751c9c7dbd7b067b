#include "engine/orient/raster_slant.h"

#include "engine/orient/directions.h"
#include "engine/orient/trapped_volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace voidpath::orient {

namespace {

/// Edges whose directions fall into the same cell of a grid of this many to a unit count as parallel.
constexpr double kCellsToUnit = 24;
/// No more directions than these are looked at, those with most edges: of many more none matters much.
constexpr std::size_t kMostDirections = 32;
/// The slopes to choose from, either way: an edge along a main axis crosses several rows even at the least,
/// and two thirds of the raster lie on the part's rectangle even at the most.
constexpr std::array<float, 8> kSlopes{0.11F, 0.15F, 0.19F, 0.23F, 0.28F, 0.33F, 0.39F, 0.45F};
/// Rows an edge as long as the part is wide is taken to meet if it ran straight across them: where it crosses
/// n of them, what a strip along it adds is n times less a matter of luck.
constexpr float kRows = 32;

}  // namespace

RasterSlant::RasterSlant(const Solid& solid) {
  std::map<std::array<int, 3>, Vec3> cells;
  for (Index t = 0; t < solid.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Index other = solid.beside[t][k];
      if (other != kNone && other < t) continue;
      Vec3 edge = solid.vertices[solid.triangles[t][(k + 1) % 3]] - solid.vertices[solid.triangles[t][k]];
      const double length = edge.norm();
      // How likely the edge is part of the outline, seen from anywhere: it grows with the angle.
      const double bend =
          other == kNone ? 2 : (solid.triangle_normals[t] - solid.triangle_normals[other]).norm();
      if (!(length * bend > 0)) continue;
      edge /= length;
      if (!is_canonical(edge)) edge = -edge;
      auto cell = [](double x) { return static_cast<int>(std::lround(x * kCellsToUnit)); };
      auto [at, is_new] = cells.try_emplace({cell(edge.x()), cell(edge.y()), cell(edge.z())}, Vec3::Zero());
      at->second += edge * length * bend;
    }
  std::vector<Vec3> all;
  for (const auto& [cell, sum] : cells) all.push_back(sum);
  std::stable_sort(all.begin(), all.end(), [](const Vec3& a, const Vec3& b) { return a.norm() > b.norm(); });
  if (all.size() > kMostDirections) all.resize(kMostDirections);
  edges_.assign(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) edges_.set(i, all[i]);
}

float RasterSlant::best(const Projection& p) const {
  const auto width = static_cast<float>(p.x_max - p.x_min);
  const auto depth = static_cast<float>(p.y_max - p.y_min);
  Lanes slopes[4];
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) slopes[i][k] = (i % 2 == 0 ? 1 : -1) * kSlopes[i / 2 * 4 + k];
  Lanes sums[4] = {};
  for (std::size_t i = 0; i < edges_.padded(); i += NearColumns::kStep) {
    const Lanes xs = edges_.dot(i, p.e1) / width;
    const Lanes ys = edges_.dot(i, p.e2) / depth;
    for (int k = 0; k < 4; ++k) {
      const float x = xs[k];
      const float y = ys[k];
      const float square = x * x;
      const float norm = std::sqrt(square + y * y);
      if (norm == 0) continue;
      for (std::size_t j = 0; j < 4; ++j) {
        const Lanes across = y + slopes[j] * x;
        const Lanes far = higher_of(across, -across) * kRows;
        const Lanes near = Lanes{} + norm;
        sums[j] += std::abs(x) * norm / higher_of(far, near);
      }
    }
  }
  float best = kSlopes[1];
  float least = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k) {
      const float slope = slopes[i][k];
      const float sum = sums[i][k] * (1 + std::abs(slope));
      if (sum < least) {
        least = sum;
        best = slope;
      }
    }
  return best;
}

}  // namespace voidpath::orient

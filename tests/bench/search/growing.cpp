#include "tests/bench/search/growing.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <tuple>

namespace voidpath::bench {

namespace {

using geom::Vec3;

/// mm; each triangle of a scan is rough by a share of its size.
constexpr double kRadius = 40;
constexpr double kRoughness = 0.05;

double radius_at(const Vec3& u) {
  const double waves = 2.5 * std::sin(9 * u.x()) * std::cos(7 * u.y() + 2 * u.z());
  const double grooves = 1.5 * std::sin(31 * u.z() + 3 * u.x());
  return kRadius + waves + std::min(grooves, 0.5);
}

}  // namespace

mesh::TriangleMesh rippled_ball(std::size_t triangles) {
  // A cube of six n × n faces, blown up to a ball.
  const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(static_cast<double>(triangles) / 12))));
  mesh::TriangleMesh out;
  std::map<std::tuple<int, int, int>, std::uint32_t> known;
  std::minstd_rand random(1);
  auto vertex = [&](int x, int y, int z) {
    const auto [it, is_new] = known.try_emplace({x, y, z}, static_cast<std::uint32_t>(out.vertices.size()));
    if (is_new) {
      auto spread = [&](int i) { return std::tan((2.0 * i / n - 1) * std::atan(1.0)); };
      const Vec3 u = Vec3(spread(x), spread(y), spread(z)).normalized();
      const double share = static_cast<double>(random() - random.min()) / (random.max() - random.min());
      out.vertices.push_back(u * (radius_at(u) + kRoughness * 2 * kRadius / n * (share - 0.5)));
    }
    return it->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          auto at = [&](int a, int b) {
            return axis == 0 ? vertex(side, a, b) : axis == 1 ? vertex(b, side, a) : vertex(a, b, side);
          };
          const std::uint32_t q[4] = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
          if (side == n) {
            out.triangles.push_back({q[0], q[1], q[2]});
            out.triangles.push_back({q[0], q[2], q[3]});
          } else {
            out.triangles.push_back({q[0], q[2], q[1]});
            out.triangles.push_back({q[0], q[3], q[2]});
          }
        }
  return out;
}

}  // namespace voidpath::bench

#include "tests/support/meshes.h"

#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <numbers>
#include <tuple>

namespace voidpath::test {

namespace {

using mesh::TriangleMesh;
using Grid = std::vector<double>;

/// The boundary of the filled cells of a grid: closed, and without T-junctions since all cells share it.
TriangleMesh blocks(const Grid& xs, const Grid& ys, const Grid& zs,
                    const std::function<bool(int, int, int)>& is_filled) {
  const int n[3] = {static_cast<int>(xs.size()) - 1, static_cast<int>(ys.size()) - 1,
                    static_cast<int>(zs.size()) - 1};
  auto filled = [&](const int c[3]) {
    for (int a = 0; a < 3; ++a)
      if (c[a] < 0 || c[a] >= n[a]) return false;
    return is_filled(c[0], c[1], c[2]);
  };
  TriangleMesh out;
  std::map<std::tuple<int, int, int>, std::uint32_t> index;
  auto vertex = [&](const int g[3]) {
    const auto [it, fresh] = index.try_emplace({g[0], g[1], g[2]}, static_cast<std::uint32_t>(out.vertices.size()));
    if (fresh)
      out.vertices.emplace_back(xs[static_cast<std::size_t>(g[0])], ys[static_cast<std::size_t>(g[1])],
                                zs[static_cast<std::size_t>(g[2])]);
    return it->second;
  };
  for (int i = 0; i < n[0]; ++i)
    for (int j = 0; j < n[1]; ++j)
      for (int k = 0; k < n[2]; ++k) {
        const int cell[3] = {i, j, k};
        if (!filled(cell)) continue;
        for (int axis = 0; axis < 3; ++axis)
          for (const int side : {0, 1}) {
            int beside[3] = {i, j, k};
            beside[axis] += side == 0 ? -1 : 1;
            if (filled(beside)) continue;
            const int u = (axis + 1) % 3;
            const int v = (axis + 2) % 3;
            std::uint32_t q[4];
            for (int c = 0; c < 4; ++c) {
              int g[3] = {i, j, k};
              g[axis] += side;
              g[u] += (c == 1 || c == 2) ? 1 : 0;
              g[v] += c >= 2 ? 1 : 0;
              q[c] = vertex(g);
            }
            if (side == 1) {
              out.triangles.push_back({q[0], q[1], q[2]});
              out.triangles.push_back({q[0], q[2], q[3]});
            } else {
              out.triangles.push_back({q[0], q[2], q[1]});
              out.triangles.push_back({q[0], q[3], q[2]});
            }
          }
      }
  return out;
}

}  // namespace

TriangleMesh box(double x, double y, double z) {
  return blocks({0, x}, {0, y}, {0, z}, [](int, int, int) { return true; });
}

TriangleMesh cube(double side) { return box(side, side, side); }

TriangleMesh cylinder(double radius, double height, int sides) {
  TriangleMesh out;
  const auto n = static_cast<std::uint32_t>(sides);
  for (const double z : {0.0, height})
    for (std::uint32_t i = 0; i < n; ++i) {
      const double a = 2 * std::numbers::pi * i / n;
      out.vertices.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
    }
  const std::uint32_t bottom = 2 * n;
  const std::uint32_t top = bottom + 1;
  out.vertices.emplace_back(0, 0, 0);
  out.vertices.emplace_back(0, 0, height);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    out.triangles.push_back({bottom, j, i});
    out.triangles.push_back({top, n + i, n + j});
    out.triangles.push_back({i, j, n + j});
    out.triangles.push_back({i, n + j, n + i});
  }
  return out;
}

TriangleMesh cup(double x, double y, double z, double wall, double floor) {
  return blocks({0, wall, x - wall, x}, {0, wall, y - wall, y}, {0, floor, z},
                [](int i, int j, int k) { return !(i == 1 && j == 1 && k == 1); });
}

TriangleMesh comb(int posts, double post, double gap, double post_height, double base_height) {
  Grid xs{0};
  for (int p = 0; p < posts; ++p) {
    xs.push_back(xs.back() + post);
    if (p + 1 < posts) xs.push_back(xs.back() + gap);
  }
  return blocks(xs, {0, post}, {0, base_height, base_height + post_height},
                [](int i, int, int k) { return k == 0 || i % 2 == 0; });
}

TriangleMesh table(double x, double y, double height, double plate, double leg) {
  return blocks({0, leg, x - leg, x}, {0, leg, y - leg, y}, {0, height - plate, height},
                [](int i, int j, int k) { return k == 1 || (i != 1 && j != 1); });
}

TriangleMesh sphere(double radius, int rings, int segments) {
  TriangleMesh out;
  const auto m = static_cast<std::uint32_t>(segments);
  const auto n = static_cast<std::uint32_t>(rings);
  out.vertices.emplace_back(0, 0, 0);
  for (std::uint32_t r = 1; r < n; ++r)
    for (std::uint32_t s = 0; s < m; ++s) {
      const double t = std::numbers::pi * r / n;
      const double a = 2 * std::numbers::pi * s / m;
      out.vertices.emplace_back(radius * std::sin(t) * std::cos(a), radius * std::sin(t) * std::sin(a),
                                radius - radius * std::cos(t));
    }
  out.vertices.emplace_back(0, 0, 2 * radius);
  const auto last = static_cast<std::uint32_t>(out.vertices.size() - 1);
  auto at = [&](std::uint32_t r, std::uint32_t s) { return 1 + (r - 1) * m + s % m; };
  for (std::uint32_t s = 0; s < m; ++s) {
    out.triangles.push_back({0, at(1, s + 1), at(1, s)});
    out.triangles.push_back({last, at(n - 1, s), at(n - 1, s + 1)});
    for (std::uint32_t r = 1; r + 1 < n; ++r) {
      out.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s + 1)});
      out.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r + 1, s)});
    }
  }
  return out;
}

TriangleMesh moved(TriangleMesh mesh, double x, double y, double z) {
  for (auto& v : mesh.vertices) v += mesh::Vec3(x, y, z);
  return mesh;
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh out = a;
  const auto base = static_cast<std::uint32_t>(a.vertices.size());
  out.vertices.insert(out.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) out.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  return out;
}

std::string shared_dir() {
  const char* dir = std::getenv("VOIDPATH_SHARED");
  return dir != nullptr ? dir : "";
}

}  // namespace voidpath::test
